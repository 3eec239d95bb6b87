// What the overlay kernel takes and gives; the method is described in overlay.cpp.
#pragma once

#include <cstdint>

#include "triangulation.hpp"

namespace henkei {

struct OverlayResult {
    Array<int32_t> faces;                 // (m, 3)
    Array<int32_t> face_a, face_b;        // (m,) face of a and of b that holds each face
    Array<int32_t> node_of_b;             // (vertices of b,); a's vertices are the first nodes
    Array<int32_t> on_face_a, on_face_b;  // (n,) a face of a and of b that holds each node
    Array<double> bary_a, bary_b;         // (n, 3) barycentric coordinates there
    Array<int64_t> plane;                 // (n, 2), in units of 2^-shift of the input's
    Array<int32_t> edges;                 // (e, 2)
    Array<int32_t> edge_a, edge_b;        // (e,) half-edge of a and of b that it is part of, or -1
    int64_t crossings = 0;
};

// `boundary` lists the nodes of the common boundary, counter-clockwise, as pairs (vertex of a or
// -1, vertex of b or -1); `shift` is the number of extra bits in which crossings are rounded.
OverlayResult overlay(const Triangulation& a, const Triangulation& b, const int32_t* boundary,
                      int64_t boundary_count, int shift);

// Indices of the triangles that are not strictly counter-clockwise.
Array<int32_t> not_positive(const PlanePoint* points, const int32_t* triangles, int64_t count);

}  // namespace henkei
