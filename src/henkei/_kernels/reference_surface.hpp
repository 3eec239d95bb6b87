// The surface that a remeshing has to keep: nearest points found by walking over it, normals that
// are smooth but for its features, and the features as curves measured by arc length.
#pragma once

#include <cstdint>
#include <vector>

#include "sphere.hpp"

namespace henkei {

// The nearest point of a triangle to p: its weights, and how far it is.
struct TrianglePoint {
    Vec weights;
    Vec point;
    double distance;
    bool thin;  // the triangle is too thin for its inside to be told from its sides
};
TrianglePoint nearest_on_triangle(const Vec& p, const Vec& a, const Vec& b, const Vec& c);
double distance_to_segment(const Vec& p, const Vec& a, const Vec& b);

struct SurfacePlace {
    int32_t face = -1;
    Vec weights{};
    Vec point{};
    double distance = 0;  // from the point that was asked for
};

// What remeshing gets: n vertices, m triangles with twins, features as bytes per half-edge (alike
// on both sides), and the wished edge length at each vertex.
struct RemeshingInput {
    const Vec* x;
    const int32_t *faces, *twins;
    const uint8_t* feature;
    const double* length;
    int64_t vertices, face_count;
};

class ReferenceSurface {
  public:
    explicit ReferenceSurface(const RemeshingInput& input);

    // Downhill from a face, over no feature: it never jumps to another sheet.
    SurfacePlace nearest(int32_t start, const Vec& p);
    Vec face_normal(int32_t f) const { return normal_of_face_[f]; }
    // Interpolated between the corners; each side of a feature has corners of its own.
    Vec normal(int32_t face, const Vec& weights) const;
    // Of the normals above the one that lies nearer to a direction.
    Vec nearer_normal(int32_t face, const Vec& weights, const Vec& direction) const;
    double length(int32_t face, const Vec& weights) const;
    SurfacePlace at_corner(int32_t h) const;

  private:
    void visit(int32_t face, const Vec& p, SurfacePlace& best);

    std::vector<Vec> x_;
    std::vector<int32_t> faces_, twins_;
    std::vector<uint8_t> feature_;
    std::vector<double> length_;
    std::vector<Vec> normal_of_face_, normals_;
    std::vector<int32_t> normal_at_;  // of each corner
    struct Door {
        int32_t half_edge;
        double distance;
    };
    std::vector<Door> doors_;
    std::vector<uint32_t> visited_;
    uint32_t search_ = 0;
};

}  // namespace henkei
