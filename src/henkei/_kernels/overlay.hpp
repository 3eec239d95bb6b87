// What the overlay kernel takes and gives; the method is described in overlay.cpp.
#pragma once

#include <cstdint>
#include <vector>

#include "plane.hpp"

namespace henkei {

// Triangles over integer points, all positive, with the twin of each half-edge (-1: boundary).
struct Triangulation {
    const PlanePoint* points;
    const int32_t* faces;
    const int32_t* twins;
    int64_t vertex_count, face_count;
};

// A place on a triangulation: on a vertex, within an edge (a half-edge) or within a face.
struct Place {
    enum Kind : int8_t { kUnknown, kVertex, kEdge, kFace } kind = kUnknown;
    int32_t id = -1;
};

struct OverlayResult {
    std::vector<int32_t> faces;            // (m, 3)
    std::vector<int32_t> face_a, face_b;   // (m,) face of a and of b that holds each face
    std::vector<int32_t> node_of_b;        // (vertices of b,); a's vertices are the first nodes
    std::vector<int32_t> on_face_a, on_face_b;  // (n,) a face of a and of b that holds each node
    std::vector<double> bary_a, bary_b;         // (n, 3) barycentric coordinates there
    std::vector<int64_t> plane;                 // (n, 2), in units of 2^-shift of the input's
    std::vector<int32_t> edges;                 // (e, 2)
    std::vector<int32_t> edge_a, edge_b;        // (e,) half-edge of a and of b that it is part of, or -1
    int64_t crossings = 0;
};

// `boundary` lists the nodes of the common boundary, counter-clockwise, as pairs (vertex of a or -1,
// vertex of b or -1); `shift` is the number of extra bits in which crossings are rounded.
OverlayResult overlay(const Triangulation& a, const Triangulation& b, const int32_t* boundary,
                      int64_t boundary_count, int shift);

// Indices of the triangles that are not strictly counter-clockwise.
std::vector<int32_t> not_positive(const PlanePoint* points, const int32_t* triangles, int64_t count);

}  // namespace henkei
