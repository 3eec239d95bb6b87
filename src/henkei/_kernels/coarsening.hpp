// Coarser and coarser versions of a triangulation of the sphere, and the way back.
// Half-edge collapses (H. Hoppe, "Progressive meshes", 1996) in rounds of independent ones, so that
// a round about halves the mesh. A collapse is made only if no face turns over on the sphere; then
// the vertex taken away, put back near the one it was drawn to, turns none over either.
#pragma once

#include <cstdint>
#include <vector>

#include "sphere.hpp"

namespace henkei {

class Coarsening {
  public:
    Coarsening(const int32_t* faces, int64_t face_count, int64_t vertices);

    // One round over the vertices that are not frozen, given where all are now on the sphere and in
    // the rest shape; returns how many were taken away.
    int64_t coarsen(const std::vector<Vec>& sphere, const Vec* rest, const uint8_t* frozen);

    // Takes the last round back; places the vertices that return.
    void refine(std::vector<Vec>& sphere);

    int64_t rounds() const { return int64_t(round_start_.size()); }
    // The vertices and faces that are left, vertices by their own numbers.
    std::vector<int32_t> vertices() const;
    std::vector<int32_t> faces() const;
    int64_t vertex_count() const { return left_; }

  private:
    struct Collapse {
        int32_t vertex, onto;
        int32_t gone[2];                 // the faces between the two
        std::vector<int32_t> moved;      // corners (half-edges) that changed from vertex to onto
        std::vector<int32_t> star_onto;  // faces around onto before
    };

    bool collapse(int32_t v, int32_t onto, const std::vector<Vec>& sphere);
    std::vector<int32_t> ring(int32_t v) const;
    bool has(int64_t face, int32_t v) const;
    void put_back(const Collapse& c, std::vector<Vec>& sphere);
    void place(const Collapse& c, std::vector<Vec>& sphere) const;

    std::vector<int32_t> corner_;             // three a face; -1 for faces that are gone
    std::vector<std::vector<int32_t>> star_;  // faces around each vertex
    std::vector<uint8_t> alive_vertex_, alive_face_;
    std::vector<Collapse> history_;
    std::vector<size_t> round_start_;
    int64_t left_;
};

// Whether a face is turned the right way on the sphere, by more than rounding.
bool upright_face(const Vec& a, const Vec& b, const Vec& c);

}  // namespace henkei
