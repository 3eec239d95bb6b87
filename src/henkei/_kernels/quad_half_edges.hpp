// A quad mesh whose quads can be taken out, with its vertices' places, and that can go back.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "sphere.hpp"

namespace henkei {

// Squared distances from planes: M. Garland, P. Heckbert, "Surface simplification using quadric
// error metrics", 1997. All planes count the same, so that small parts of a surface are kept.
class Quadric {
  public:
    void add_plane(const Vec& normal, const Vec& point);
    Quadric& operator+=(const Quadric& other);
    double mean(const Vec& point) const;

  private:
    double square_[6] = {}, linear_[3] = {}, constant_ = 0;
    int64_t planes_ = 0;
};

// Rows of half-edges, 4 q + i from corner i to corner i + 1 of quad q.
struct QuadsWithSizes {
    std::vector<Vec> points;
    std::vector<double> sizes;     // wished edge length at each vertex
    std::vector<int32_t> origin;   // (4 q,) of each half-edge: the quads
    std::vector<int32_t> twin;     // (4 q,), -1 on the boundary
    std::vector<int32_t> feature;  // (4 q,) whether it lies on a feature line
    std::vector<int32_t> rank;     // of each vertex: 2 stays, 1 on a feature line, 0 free
    std::vector<int32_t> wished;   // valence of each vertex
};

class QuadHalfEdges {
  public:
    explicit QuadHalfEdges(QuadsWithSizes quads);

    static int next(int h) { return (h & 3) == 3 ? h - 3 : h + 1; }
    static int previous(int h) { return (h & 3) == 0 ? h + 3 : h - 1; }
    static int opposite(int h) { return h ^ 2; }

    const QuadsWithSizes& quads() const { return mesh_; }
    int64_t count() const { return count_; }
    bool alive(int quad) const { return alive_[quad]; }
    int origin(int h) const { return mesh_.origin[h]; }
    int target(int h) const { return mesh_.origin[next(h)]; }
    int twin(int h) const { return mesh_.twin[h]; }
    bool feature(int h) const { return mesh_.feature[h]; }
    int rank(int v) const { return mesh_.rank[v]; }
    bool border(int v) const { return border_[v]; }
    int valence(int v) const { return valence_[v]; }
    int wished(int v) const { return mesh_.wished[v]; }
    int excess(int v) const { return valence_[v] - mesh_.wished[v]; }
    bool exists(int v) const { return out_[v] >= 0; }
    const Vec& point(int v) const { return mesh_.points[v]; }
    double size(int v) const { return mesh_.sizes[v]; }

    // Squared distance, in wished edges, from the surface to where two vertices would become one.
    double harm(int a, int b) const;

    // One quad goes; the vertex at which the half-edge starts and the opposite one become one.
    // False if that cannot be; then call undo.
    bool collapse_diagonal(int h);
    // A row of quads goes, each entered over one of the half-edges, which shrink to vertices.
    bool collapse_row(const std::vector<int>& entries, bool closed);
    // Whether the quads around a vertex are proper, no two of its edges end at the same vertex, and
    // its valence, which is counted anew, is within limits.
    bool check(int v, int least, int most);
    void undo();  // all that was done since the last commit
    void commit();

    // Calls f with each half-edge that starts at a vertex.
    template <class F>
    void around(int v, F f) const {
        const int first = out_[v];
        int h = first;
        do {
            f(h);
            h = mesh_.twin[previous(h)];
        } while (h >= 0 && h != first);
        if (h == first) return;
        for (h = mesh_.twin[first]; h >= 0; h = mesh_.twin[h]) {
            h = next(h);
            f(h);
        }
    }

    // Moves free vertices towards their neighbours, as far as they stay near the surface.
    void smooth();

  private:
    struct Place {
        int vertex;
        Vec point;
        double size;
        Quadric quadric;
    };
    void set(int32_t& value, int32_t to);
    void merge(int kept, int gone);
    void join(int h, int g);
    void remove(int quad);
    void start_at(int v, std::initializer_list<int> half_edges);
    Vec joint_place(int a, int b, const Quadric& both) const;
    int kept_of(int a, int b) const { return rank(b) > rank(a) ? b : a; }

    QuadsWithSizes mesh_;
    std::vector<Quadric> quadric_;
    std::vector<int32_t> alive_, out_, valence_, border_;
    std::vector<int> neighbours_;
    std::vector<std::pair<int32_t*, int32_t>> log_;
    std::vector<Place> places_;
    int64_t count_;
};

}  // namespace henkei
