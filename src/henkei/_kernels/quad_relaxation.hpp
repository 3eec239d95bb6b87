// A quad mesh that moves along a surface; the method is described in quad_relaxation.cpp.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "closest_points.hpp"
#include "surface_places.hpp"

namespace henkei {

// Polylines along edges of the surface, to which vertices are bound. The points of line i are
// [start[i], start[i + 1]); a closed line repeats its first point at its end. The segment that
// starts at a point runs along a half-edge, or backwards along it (then as -1 - half_edge).
struct QuadLines {
    std::vector<int64_t> start;
    std::vector<Vec> point;
    std::vector<double> arc;  // length of the line up to each point
    std::vector<int32_t> half_edge;
    std::vector<uint8_t> closed;
};

class QuadRelaxation {
  public:
    // face, weights: where each vertex is on the surface. points: the same; held vertices keep
    // them. line: that each vertex is bound to, at arc length `arc`, or -1. beside: the vertices
    // before and after it on the line, or -1 where they are held, at arc lengths `limits`. size:
    // wished length of edges at each vertex. centre: a face near each quad's centre.
    QuadRelaxation(SurfacePlaces surface, ClosestPoints closest, QuadLines lines,
                   std::vector<int32_t> quads, const int32_t* face, const double* weights,
                   const double* points, int64_t vertex_count, std::vector<uint8_t> held,
                   const int32_t* line, const double* arc, const int32_t* beside,
                   const double* limits, std::vector<double> size, const int32_t* centre);

    int64_t vertex_count() const { return int64_t(spot_.size()); }
    int64_t quad_count() const { return int64_t(quads_.size()) / 4; }

    void fit(int iterations, double evenness);
    void improve(int sweeps, double power, double stretch, double evenness);
    void untangle(int sweeps, double floor, uint64_t seed);
    // Puts vertices to the places given and holds them there.
    void pin(const int32_t* vertices, const int32_t* face, const double* weights, int64_t count);
    // Where a quad is bad its neighbourhood is shaken and relaxed anew, up to `tries` times; what
    // comes of it is kept where fewer quads are bad then, or the worst is better.
    void mend(int tries, uint64_t seed);
    void save(int slot);     // where all vertices are, and which are held
    void restore(int slot);  // what was saved there last

    // The scaled Jacobian of each quad, less if it faces away from the surface.
    void quality(double* standing);
    void result(double* points, int32_t* face, double* weights) const;

  private:
    static constexpr double kLeastRoom = 0.1;  // of the way to a neighbour on a line stays free

    struct Spot {
        WalkedPlace place;
        double arc;
    };
    struct Bound {
        int32_t line, before, after;
        double low, high;
    };

    const Vec& corner(int64_t quad, int k) const {
        return spot_[quads_[4 * quad + (k & 3)]].place.point;
    }
    struct Region {
        std::vector<int32_t> vertices;  // those that are free
        std::vector<int64_t> quads;
    };
    struct State {
        std::vector<Spot> spot;
        std::vector<uint8_t> held;
    };

    void find_centre(int64_t quad);
    void find_centres();
    double room(int32_t v, bool forwards) const;
    std::pair<Vec, Vec> directions(int32_t v) const;
    Spot moved(int32_t v, const Vec& to, double share);
    Spot on_line(int32_t v, const Vec& to, double low, double high) const;
    double jacobian(int64_t quad) const;
    double distortion(int32_t v, double power, double stretch) const;
    double standing(int64_t quad) const;
    double risk(int32_t v) const;
    double reach(int32_t v) const;
    bool try_step(int32_t v, const Vec& step, double power, double stretch, double before);
    void newton(int32_t v, double power, double stretch);
    void search(int32_t v, double angle);
    Region around(int64_t quad, int rings) const;
    std::pair<int, double> fault(const Region& region) const;
    bool try_anew(const Region& region, double shake, uint64_t& random);

    SurfacePlaces surface_;
    ClosestPoints closest_;  // on any sheet
    QuadLines lines_;
    std::vector<int32_t> quads_;
    std::vector<int64_t> ring_start_;
    std::vector<int32_t> ring_;  // corners 4 q + k at each vertex
    std::vector<Spot> spot_;
    std::vector<Bound> bound_;
    std::vector<uint8_t> held_;
    std::vector<double> size_;
    std::vector<State> saved_;
    std::vector<double> wished_;  // area of each quad
    double evenness_ = 0;
    std::vector<WalkedPlace> centre_;
    std::vector<Vec> up_;  // normal of the surface at each quad's centre
};

}  // namespace henkei
