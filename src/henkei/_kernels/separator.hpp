// A small set of a graph's vertices whose removal leaves two parts of about the same size.
#pragma once

#include <cstdint>
#include <vector>

namespace henkei {

// Neighbours of vertex v: to[start[v]..start[v + 1]), not v itself, each once.
struct Graph {
    std::vector<int64_t> start;
    std::vector<int32_t> to;
    std::vector<int32_t> strength;  // of each edge: how many it stands for
    std::vector<int32_t> weight;    // of each vertex: how many it stands for

    int32_t size() const { return int32_t(weight.size()); }
};

// The part of each vertex: 0 and 1, with no edge between them, and kSeparator.
constexpr int8_t kSeparator = 2;
std::vector<int8_t> separate(const Graph& graph);

}  // namespace henkei
