// Twins of half-edges: the half-edge that runs the other way along the same edge.
// Half-edges are bucketed by their smaller vertex (counting sort), each bucket sorted by the larger
// one, so a vertex of any degree costs O(d log d).
#include "kernels.hpp"

#include <algorithm>

namespace henkei {

void half_edge_twins(const int32_t* origin, const int32_t* target, int64_t half_edges,
                     int64_t vertices, int32_t* twin) {
    std::vector<int64_t> start(vertices + 1, 0);
    for (int64_t h = 0; h < half_edges; ++h) ++start[std::min(origin[h], target[h]) + 1];
    for (int64_t v = 0; v < vertices; ++v) start[v + 1] += start[v];

    struct Entry {
        int32_t other, half_edge;
    };
    std::vector<Entry> bucket(half_edges);
    std::vector<int64_t> fill(start.begin(), start.end() - 1);
    for (int64_t h = 0; h < half_edges; ++h) {
        const int32_t low = std::min(origin[h], target[h]), high = std::max(origin[h], target[h]);
        bucket[fill[low]++] = {high, int32_t(h)};
    }
    for (int64_t v = 0; v < vertices; ++v) {
        if (v % 65536 == 0) check_interrupt();
        Entry* first = bucket.data() + start[v];
        Entry* last = bucket.data() + start[v + 1];
        std::sort(first, last, [](const Entry& a, const Entry& b) {
            return a.other != b.other ? a.other < b.other : a.half_edge < b.half_edge;
        });
        while (first != last) {
            Entry* end = first;
            while (end != last && end->other == first->other) ++end;
            const int32_t g = first->half_edge, h = first[end - first > 1].half_edge;
            if (end - first == 1) {
                twin[g] = kBoundary;
            } else if (end - first > 2) {
                for (Entry* e = first; e != end; ++e) twin[e->half_edge] = kNotManifold;
            } else if (origin[g] == origin[h]) {
                twin[g] = twin[h] = kNotOriented;
            } else {
                twin[g] = h;
                twin[h] = g;
            }
            first = end;
        }
    }
}

}  // namespace henkei
