// What the kernels offer, over plain arrays; bind.cpp gives them to Python.
#pragma once

#include <cstdint>
#include <vector>

namespace henkei {

// Lets Ctrl-C end a long kernel: takes the GIL for a moment, throws if a signal handler raised.
void check_interrupt();

// Values of `twin` that are not a half-edge.
constexpr int32_t kBoundary = -1, kNotManifold = -2, kNotOriented = -3;

void half_edge_twins(const int32_t* origin, const int32_t* target, int64_t half_edges,
                     int64_t vertices, int32_t* twin);

// Pairs of faces that intersect, as (f0, g0, f1, g1, ...); at most `limit` pairs.
std::vector<int32_t> self_intersections(const double* vertices, int64_t vertex_count,
                                        const int32_t* faces, int64_t face_count, int64_t limit);

}  // namespace henkei
