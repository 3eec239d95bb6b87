// Inner products of hat functions as if all faces had one area (section 3.2 of Takahashi, 2000):
// area / 12 (1 + delta_ij) for corners of a triangle; of a quad's bilinear functions, area / 36 by
// 4 for a corner with itself, 2 for neighbours and 1 for opposite corners.
#include <algorithm>

#include "design.hpp"

namespace henkei {

namespace {

// The corners at each vertex.
VertexRows corners_of(int64_t vertices, const int32_t* indices, int64_t corners) {
    VertexRows rows;
    // Counted one place late, summed, then moved on while filled in: the rows' starts remain.
    rows.start.assign(size_t(vertices) + 2, 0);
    int32_t* next = rows.start.data() + 1;
    for (int64_t c = 0; c < corners; ++c) ++next[indices[c] + 1];
    for (int64_t i = 0; i < vertices; ++i) next[i + 1] += next[i];
    rows.indices.resize(size_t(corners));
    for (int64_t c = 0; c < corners; ++c) rows.indices[size_t(next[indices[c]]++)] = int32_t(c);
    rows.start.pop_back();
    return rows;
}

// Rows of the matrix in parts of the area, columns in no order.
struct Parts {
    Array<int32_t> start, indices, parts;
};

template <int Corners>
Parts gathered(int64_t vertices, const int32_t* indices, int64_t faces) {
    constexpr int32_t kParts[] = {Corners == 3 ? 2 : 4, Corners == 3 ? 1 : 2, 1, 2};
    const VertexRows at = corners_of(vertices, indices, Corners * faces);
    Parts rows;
    rows.start.resize(size_t(vertices) + 1);
    rows.start[0] = 0;
    rows.indices.reserve(size_t(Corners * faces * (Corners - 1) + vertices));
    rows.parts.reserve(rows.indices.capacity());
    std::vector<int32_t> place(size_t(vertices), -1);  // of a column in the rows so far
    for (int64_t i = 0; i < vertices; ++i) {
        for (int32_t k = at.start[size_t(i)]; k < at.start[size_t(i) + 1]; ++k) {
            const int32_t corner = at.indices[size_t(k)] % Corners;
            const int32_t* face = indices + at.indices[size_t(k)] - corner;
            for (int step = 0; step < Corners; ++step) {
                const int32_t column = face[(corner + step) % Corners];
                int32_t& here = place[size_t(column)];
                if (here < rows.start[size_t(i)]) {
                    here = int32_t(rows.indices.size());
                    rows.indices.push_back(column);
                    rows.parts.push_back(0);
                }
                rows.parts[size_t(here)] += kParts[step];
            }
        }
        rows.start[size_t(i) + 1] = int32_t(rows.indices.size());
    }
    return rows;
}

}  // namespace

// The matrix is symmetric: its transpose is the same, with columns in order.
HatProducts hat_products(int64_t vertices, const int32_t* indices, int64_t faces, int corners,
                         double area) {
    Parts rows = corners == 3 ? gathered<3>(vertices, indices, faces)
                              : gathered<4>(vertices, indices, faces);
    const double part = corners == 3 ? area / 12 : area / 36;
    HatProducts products;
    products.start = rows.start;
    products.indices.resize(rows.indices.size());
    products.values.resize(rows.indices.size());
    Array<int32_t>& next = rows.start;
    int32_t k = 0;
    for (int64_t i = 0; i < vertices; ++i) {
        for (; k < products.start[size_t(i) + 1]; ++k) {
            const size_t to = size_t(next[size_t(rows.indices[size_t(k)])]++);
            products.indices[to] = int32_t(i);
            products.values[to] = part * rows.parts[size_t(k)];
        }
    }
    return products;
}

}  // namespace henkei
