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

}  // namespace henkei
