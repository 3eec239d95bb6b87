// A closed triangle mesh that is taken apart, vertex by vertex, down to a tetrahedron, and put
// together again in the opposite order.
// H. Hoppe, "Progressive Meshes", SIGGRAPH 1996, with half-edge collapses, so that the vertices of
// every coarse mesh are vertices of the finest; in independent sets of vertices of few neighbours,
// as in D. Dobkin, D. Kirkpatrick, "Determining the separation of preprocessed polyhedra", 1990,
// so that there are O(log n) levels and every collapse is cheap.
#pragma once

#include <cstdint>
#include <vector>

#include "sphere.hpp"

namespace henkei {

// Half-edges are numbered by corners: h starts at corner[h] and lies in face h / 3.
class Hierarchy {
  public:
    // Takes a closed oriented manifold apart. Without vertices (null), by its connectivity alone.
    Hierarchy(const double* vertices, int64_t vertex_count, const int32_t* faces,
              const int32_t* twins, int64_t face_count);

    static int32_t next(int32_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
    static int32_t previous(int32_t h) { return h % 3 == 0 ? h + 2 : h - 1; }
    int32_t origin(int32_t h) const { return corner_[h]; }
    int32_t target(int32_t h) const { return corner_[next(h)]; }
    int32_t leaving(int32_t v) const { return leaving_[v]; }
    // The half-edge after h around its origin, counter-clockwise.
    int32_t turned(int32_t h) const { return twin_[previous(h)]; }

    // Vertices of the mesh as it is now.
    const std::vector<int32_t>& present() const { return present_; }
    // How many collapses the coming level undoes; 0 when the mesh is whole.
    int64_t level_size() const { return levels_.empty() ? 0 : levels_.back(); }
    // The vertex that comes back next, and its neighbours, counter-clockwise from the one that it
    // had gone to.
    int32_t coming() const { return corner_[collapses_.back()]; }
    void coming_ring(std::vector<int32_t>& ring) const;
    // Undoes the last collapse.
    void split();

    double area(int32_t face) const { return area_[face]; }
    const Vec& point(int32_t v) const { return point_[v]; }

  private:
    struct Choice {
        double cost;
        int32_t half_edge;
    };

    bool collapse_level();
    Choice best_collapse(int32_t v);
    bool keeps_sphere(int32_t u_at, int32_t degree) const;
    bool joined(int32_t a, int32_t b) const;
    void collapse(int32_t h);
    void find_ring(int32_t v);

    std::vector<Vec> point_;
    std::vector<int32_t> corner_, twin_, leaving_, degree_, present_;
    std::vector<double> area_;        // of each face; of a coarse one, of what it stands for
    std::vector<int32_t> collapses_;  // half-edges from the vertex that goes
    std::vector<int64_t> levels_;     // number of collapses in each level
    std::vector<double> areas_;       // what collapses changed, to be undone from the back
    std::vector<int32_t> ring_;       // half-edges that leave a vertex
};

}  // namespace henkei
