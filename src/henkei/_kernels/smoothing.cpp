// Smoothing by the mean of neighbours (Taubin, *A signal processing approach to fair surface
// design*, 1995), along the boundary where there is one.
#include <algorithm>

#include "columns.hpp"
#include "design.hpp"
#include "vectorised.hpp"
#include "vectors.hpp"

namespace henkei {

namespace {

// Of the edges of all corners, those that occur once.
std::vector<uint8_t> boundary_edges(const int32_t* corner_edges, int64_t corners, int64_t edges) {
    std::vector<uint8_t> sides(size_t(edges), 0);
    for (int64_t c = 0; c < corners; ++c) {
        uint8_t& met = sides[size_t(corner_edges[c])];
        met = met ? 2 : 1;
    }
    for (uint8_t& met : sides) met = met == 1;
    return sides;
}

template <class Use>
void each_neighbour(const int32_t* edges, const std::vector<uint8_t>& boundary,
                    const std::vector<uint8_t>& on_boundary, Use use) {
    for (size_t e = 0; e < boundary.size(); ++e) {
        const int32_t a = edges[2 * e], b = edges[2 * e + 1];
        if (boundary[e] || !on_boundary[size_t(a)]) use(a, b);
        if (boundary[e] || !on_boundary[size_t(b)]) use(b, a);
    }
}

// Columns of a row of `stride` numbers.
template <int Width>
void smooth_row(const int32_t* neighbours, int32_t count, const double* values, int64_t stride,
                int64_t row, const double* factors, double* out) {
    double sum[Width] = {};
    for (int32_t k = 0; k < count; ++k) {
        const double* from = values + stride * neighbours[k];
        for (int c = 0; c < Width; ++c) sum[c] += from[c];
    }
    const double share = 1.0 / count;
    const double* own = values + stride * row;
    for (int c = 0; c < Width; ++c) {
        out[stride * row + c] = own[c] + factors[c] * (share * sum[c] - own[c]);
    }
}

template <int Width, int Stride>
void smooth(const int32_t* start, const int32_t* neighbours, int64_t count, const double* values,
            int64_t columns, const double* factors, const uint8_t* free, double* out) {
    const int64_t stride = Stride ? Stride : columns;
    for (int64_t i = 0; i < count; ++i) {
        const int32_t first = start[i], last = start[i + 1];
        if (first == last || (free != nullptr && !free[i])) {
            std::copy_n(values + stride * i, Width, out + stride * i);
        } else {
            smooth_row<Width>(neighbours + first, last - first, values, stride, i, factors, out);
        }
    }
}

HENKEI_INLINE const Four& four(const double* p) {
    return *reinterpret_cast<const Four*>(p);
}

struct Smoothing {
    const int32_t *start, *neighbours;
    int64_t count;
    const double *values, *factors;
    const uint8_t* free;
    double* out;
};

// Three columns of the rows from i on that have `Size` neighbours and are free; returns the first
// that does not. They are vectors of four numbers: the last is read from the next row, which writes
// over it, too. The last row of all has no next, so that is left out, and rows next to it.
template <int Size>
HENKEI_INLINE int64_t smooth_alike(const Smoothing s, int64_t i) {
    constexpr double kShare = 1.0 / Size;
    const Four shares = {kShare, kShare, kShare, kShare};
    const Four factor = {s.factors[0], s.factors[1], s.factors[2], 0};
    const int64_t last = s.count - 1;
    const int32_t* rows = s.neighbours + s.start[i];
    int32_t end = s.start[i] + Size;
    for (; i < last && s.start[i + 1] == end && rows[Size - 1] != last; ++i) {
        if (s.free != nullptr && !s.free[i]) break;
        Four sum = {};
        HENKEI_UNROLL for (int k = 0; k < Size; ++k) sum += four(s.values + 3 * int64_t(rows[k]));
        const Four own = four(s.values + 3 * i);
        *reinterpret_cast<Four*>(s.out + 3 * i) = own + factor * (sum * shares - own);
        rows += Size;
        end += Size;
    }
    return i;
}

HENKEI_VECTORISED
void smooth_points(const Smoothing& s) {
    for (int64_t i = 0; i < s.count; ++i) {
        i = smooth_alike<4>(s, i);  // most vertices of quads
        i = smooth_alike<6>(s, i);  // most of triangles
        const int32_t *rows = s.neighbours + s.start[i], size = s.start[i + 1] - s.start[i];
        if (size == 0 || (s.free != nullptr && !s.free[i])) {
            std::copy_n(s.values + 3 * i, 3, s.out + 3 * i);
        } else {
            smooth_row<3>(rows, size, s.values, 3, i, s.factors, s.out);
        }
    }
}

}  // namespace

VertexRows smoothing_neighbours(int64_t vertices, const int32_t* edges, int64_t edge_count,
                                const int32_t* corner_edges, int64_t corners) {
    const std::vector<uint8_t> boundary = boundary_edges(corner_edges, corners, edge_count);
    std::vector<uint8_t> on_boundary(size_t(vertices), 0);
    for (size_t e = 0; e < boundary.size(); ++e) {
        if (boundary[e]) on_boundary[size_t(edges[2 * e])] = 1;
        if (boundary[e]) on_boundary[size_t(edges[2 * e + 1])] = 1;
    }
    VertexRows rows;
    // Counted one place late, summed, then moved on while filled in: the rows' starts remain.
    rows.start.assign(size_t(vertices) + 2, 0);
    int32_t* next = rows.start.data() + 1;
    each_neighbour(edges, boundary, on_boundary, [&](int32_t a, int32_t) { ++next[a + 1]; });
    for (int64_t i = 0; i < vertices; ++i) next[i + 1] += next[i];
    rows.indices.resize(size_t(next[vertices]));
    each_neighbour(edges, boundary, on_boundary,
                   [&](int32_t a, int32_t b) { rows.indices[size_t(next[a]++)] = b; });
    rows.start.pop_back();
    for (int64_t i = 0; i < vertices; ++i) {
        std::sort(rows.indices.begin() + rows.start[size_t(i)],
                  rows.indices.begin() + rows.start[size_t(i) + 1]);
    }
    return rows;
}

void smoothed(const int32_t* start, const int32_t* neighbours, int64_t count, const double* values,
              int64_t columns, const double* factors, const uint8_t* free, double* out) {
    if (columns == 3) return smooth_points({start, neighbours, count, values, factors, free, out});
    in_columns(columns, [&](auto width, auto stride, int64_t first) {
        smooth<decltype(width)::value, decltype(stride)::value>(
            start, neighbours, count, values + first, columns, factors + first, free, out + first);
    });
}

}  // namespace henkei
