// Nested dissection: the unknowns of a separator are eliminated after those of the parts it leaves,
// which are ordered in the same way. What is in small parts comes first, by minimum degree.
// George, "Nested dissection of a regular finite element mesh", SIAM J. Numer. Anal. 10, 1973.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "ordering.hpp"
#include "separator.hpp"

namespace henkei {

namespace {

using Ints = std::vector<int32_t>;

constexpr int32_t kSmall = 1000;  // unknowns up to which a part is not dissected

// Part of the graph, and the unknowns that its vertices are.
struct Piece {
    Graph graph;
    Ints unknown;
};

// Without unknowns of very many neighbours, which are given back: they would be in any separator.
Ints without_dense(const Pattern& pattern, Piece& piece) {
    const double most = std::max(40.0, 10 * std::sqrt(double(pattern.size)));
    Ints dense, place(pattern.size, -1);
    for (int32_t i = 0; i < pattern.size; ++i) {
        if (pattern.start[i + 1] - pattern.start[i] > most) {
            dense.push_back(i);
        } else {
            place[i] = int32_t(piece.unknown.size());
            piece.unknown.push_back(i);
        }
    }
    Graph& graph = piece.graph;
    graph.start.assign(1, 0);
    for (int32_t i : piece.unknown) {
        for (int32_t e = pattern.start[i]; e < pattern.start[i + 1]; ++e) {
            const int32_t j = pattern.row[e];
            if (j != i && place[j] >= 0) graph.to.push_back(place[j]);
        }
        graph.start.push_back(int64_t(graph.to.size()));
    }
    graph.weight.assign(piece.unknown.size(), 1);
    graph.strength.assign(graph.to.size(), 1);
    return dense;
}

Piece part_of(const Piece& piece, const std::vector<int8_t>& part, int8_t wanted, Ints& place) {
    Piece result;
    for (int32_t v = 0; v < piece.graph.size(); ++v) {
        if (part[v] != wanted) continue;
        place[v] = int32_t(result.unknown.size());
        result.unknown.push_back(piece.unknown[v]);
    }
    result.graph.start.assign(1, 0);
    for (int32_t v = 0; v < piece.graph.size(); ++v) {
        if (part[v] != wanted) continue;
        for (int64_t e = piece.graph.start[v]; e < piece.graph.start[v + 1]; ++e) {
            const int32_t u = piece.graph.to[e];
            if (part[u] == wanted) result.graph.to.push_back(place[u]);
        }
        result.graph.start.push_back(int64_t(result.graph.to.size()));
    }
    result.graph.weight.assign(result.unknown.size(), 1);
    result.graph.strength.assign(result.graph.to.size(), 1);
    return result;
}

}  // namespace

std::vector<int32_t> nested_dissection(const Pattern& pattern) {
    // What comes after the small parts, from the last to be eliminated to the first.
    Piece whole;
    Ints last = without_dense(pattern, whole), place(pattern.size);
    std::vector<Piece> pieces;
    pieces.push_back(std::move(whole));
    while (!pieces.empty()) {
        const Piece piece = std::move(pieces.back());
        pieces.pop_back();
        if (piece.graph.size() <= kSmall) continue;
        const std::vector<int8_t> part = separate(piece.graph);
        Piece parts[2] = {part_of(piece, part, 0, place), part_of(piece, part, 1, place)};
        if (10 * std::min(parts[0].unknown.size(), parts[1].unknown.size()) < part.size()) {
            continue;  // there is no small separator
        }
        for (int32_t v = 0; v < piece.graph.size(); ++v) {
            if (part[v] == kSeparator) last.push_back(piece.unknown[v]);
        }
        pieces.push_back(std::move(parts[0]));
        pieces.push_back(std::move(parts[1]));
    }
    std::vector<uint8_t> later(pattern.size, 0);
    for (int32_t i : last) later[i] = 1;
    Ints order = minimum_degree_before(pattern, later.data());
    order.insert(order.end(), last.rbegin(), last.rend());
    return order;
}

}  // namespace henkei
