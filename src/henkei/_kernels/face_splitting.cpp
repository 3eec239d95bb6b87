// Planar refinement (section 2 and fig. 1 of Takahashi, *Designing subdivision surfaces via
// multiresolution-based local filtering*, 2000): triangles into four, others into quads. Edge e =
// (a, b) with midpoint m becomes 2e = (a, m) and 2e + 1 = (b, m), so nothing is sorted.
#include <algorithm>

#include "design.hpp"

namespace henkei {

namespace {

// The half, at a vertex, of one of its edges.
int32_t half(const CageView& cage, int32_t edge, int32_t vertex) {
    return 2 * edge + (cage.edges[2 * int64_t(edge)] != vertex);
}

RefinedFaces with_halves(const CageView& cage, int64_t corners, int64_t inner_edges) {
    RefinedFaces r{Unfilled<int32_t>(size_t(corners)),
                   Unfilled<int32_t>(size_t(2 * (2 * cage.edge_count + inner_edges))),
                   Unfilled<int32_t>(size_t(corners))};
    int32_t* out = r.edges.data();
    for (int64_t e = 0; e < cage.edge_count; ++e, out += 4) {
        out[0] = cage.edges[2 * e];
        out[2] = cage.edges[2 * e + 1];
        out[1] = out[3] = int32_t(cage.vertices + e);
    }
    return r;
}

void add_mean(const double* values, int64_t columns, const int32_t* rows, int64_t count,
              double* out) {
    const double share = 1.0 / double(count);
    for (int64_t c = 0; c < columns; ++c) {
        double sum = 0;
        for (int64_t k = 0; k < count; ++k) sum += values[columns * rows[k] + c];
        out[c] = share * sum;
    }
}

}  // namespace

RefinedFaces refined_triangles(const CageView& cage) {
    RefinedFaces r = with_halves(cage, 4 * cage.corners, cage.corners);
    const int32_t middle = int32_t(cage.vertices);
    int32_t inner = int32_t(2 * cage.edge_count);
    int32_t *corner = r.indices.data(), *edge = r.corner_edges.data();
    int32_t* ends = r.edges.data() + 2 * int64_t(inner);
    for (int64_t c = 0; c < cage.corners; c += 3, corner += 12, edge += 12, inner += 3) {
        const int32_t *face = cage.indices + c, *sides = cage.corner_edges + c;
        for (int i = 0; i < 3; ++i, ends += 2) {
            const int before = (i + 2) % 3;
            corner[3 * i] = face[i];
            corner[3 * i + 1] = corner[9 + i] = ends[0] = middle + sides[i];
            corner[3 * i + 2] = ends[1] = middle + sides[before];
            edge[3 * i] = half(cage, sides[i], face[i]);
            edge[3 * i + 1] = edge[9 + before] = inner + i;
            edge[3 * i + 2] = half(cage, sides[before], face[i]);
        }
    }
    return r;
}

RefinedFaces refined_quads(const CageView& cage, const int64_t* offsets, int64_t faces) {
    RefinedFaces r = with_halves(cage, 4 * cage.corners, cage.corners);
    const int32_t middle = int32_t(cage.vertices), inner = int32_t(2 * cage.edge_count);
    int32_t *corner = r.indices.data(), *edge = r.corner_edges.data();
    int32_t* ends = r.edges.data() + 2 * int64_t(inner);
    for (int64_t f = 0; f < faces; ++f) {
        const int32_t centre = int32_t(cage.vertices + cage.edge_count + f);
        int64_t before = offsets[f + 1] - 1;
        for (int64_t c = offsets[f]; c < offsets[f + 1]; before = c++) {
            const int32_t vertex = cage.indices[c];
            const int32_t side = cage.corner_edges[c], side_before = cage.corner_edges[before];
            corner[0] = vertex;
            corner[1] = ends[0] = middle + side;
            corner[2] = ends[1] = centre;
            corner[3] = middle + side_before;
            edge[0] = half(cage, side, vertex);
            edge[1] = int32_t(inner + c);
            edge[2] = int32_t(inner + before);
            edge[3] = half(cage, side_before, vertex);
            corner += 4;
            edge += 4;
            ends += 2;
        }
    }
    return r;
}

void refined_vertices(const CageView& cage, const int64_t* offsets, int64_t faces,
                      const double* values, int64_t columns, double* out) {
    out = std::copy_n(values, columns * cage.vertices, out);
    for (int64_t e = 0; e < cage.edge_count; ++e, out += columns) {
        add_mean(values, columns, cage.edges + 2 * e, 2, out);
    }
    for (int64_t f = 0; f < faces; ++f, out += columns) {
        add_mean(values, columns, cage.indices + offsets[f], offsets[f + 1] - offsets[f], out);
    }
}

}  // namespace henkei
