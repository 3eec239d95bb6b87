// What elimination fills in, found before it is done: the tree, the panels and their rows.
#pragma once

#include <cstdint>
#include <vector>

namespace henkei {

// The pattern of a symmetric matrix, all entries: those of column j are row[start[j]..start[j+1]).
struct Pattern {
    int32_t size;
    const int32_t *start, *row;
};

// Columns first[p]..first[p+1] form panel p. Below its square on the diagonal the factor is not
// zero in `below[p]` rows, ascending from rows[rows_at[p]] on. Its values are stored row after row
// from values_at[p] on, the square first. Columns are counted in the order of elimination.
struct Panels {
    std::vector<int32_t> order;     // the unknown that is eliminated k-th
    std::vector<int32_t> position;  // its inverse
    std::vector<int32_t> first, below, rows;
    std::vector<int64_t> rows_at, values_at;

    int32_t count() const { return int32_t(below.size()); }
    int32_t columns(int32_t panel) const { return first[panel + 1] - first[panel]; }
};

// order: an elimination order; the result's is one of the same fill.
Panels find_panels(const Pattern& pattern, const int32_t* order);

}  // namespace henkei
