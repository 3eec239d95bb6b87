// What the collapsing of chords takes and gives; the method is described in quad_chords.cpp.
#pragma once

#include <cstdint>
#include <vector>

#include "quad_half_edges.hpp"

namespace henkei {

struct CollapsedQuads {
    std::vector<double> points;    // (n, 3)
    std::vector<int32_t> quads;    // (k, 4) of those left, rows of the points given
    std::vector<int32_t> numbers;  // (k,) which ones they are
    std::vector<uint8_t> feature;  // (k, 4) whether the edge from each corner is on a feature line
    int64_t chords = 0;            // whole ones and parts that were collapsed
};

// Collapses chords and parts of chords until no more than so many quads are left, or none can be.
CollapsedQuads collapse_chords(QuadsWithSizes quads, int64_t target);

}  // namespace henkei
