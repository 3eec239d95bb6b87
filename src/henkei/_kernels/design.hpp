// The loops of a design on a subdivided cage. Most end within a tenth of a second for
// a million vertices, so they are not interruptible.
#pragma once

#include <cstdint>
#include <vector>

#include "deformation.hpp"
#include "memory.hpp"

namespace henkei {

// Faces as their corners in a row, with the edges (e, 2) and the edge from each corner to the next.
struct CageView {
    int64_t vertices;
    const int32_t *indices, *edges, *corner_edges;
    int64_t corners, edge_count;
};

struct RefinedFaces {
    Unfilled<int32_t> indices, edges, corner_edges;
};

// The four children of each triangle, or the quad at each corner of faces from offsets[f] to
// offsets[f + 1] (faces + 1). New vertices are the midpoints by edge, then centres by face.
RefinedFaces refined_triangles(const CageView& cage);
RefinedFaces refined_quads(const CageView& cage, const int64_t* offsets, int64_t faces);

// Rows (vertices, columns), then their means for each edge, then for each of the faces.
void refined_vertices(const CageView& cage, const int64_t* offsets, int64_t faces,
                      const double* values, int64_t columns, double* out);

// Rows of vertices: those of i are indices[start[i]] to indices[start[i + 1] - 1].
struct VertexRows {
    Array<int32_t> start, indices;
};

// The neighbours of each vertex over `edges` (e, 2), ascending. Where an edge is a side of one face
// only, that is, is once among the edges of all corners, its ends keep such neighbours alone.
VertexRows smoothing_neighbours(int64_t vertices, const int32_t* edges, int64_t edge_count,
                                const int32_t* corner_edges, int64_t corners);

// out_i = x_i + factor (mean of the neighbours' x - x_i) in each of the columns of values (n,
// columns) by its factor, and x_i where `free` (which may be null) is 0 or no neighbours are.
void smoothed(const int32_t* start, const int32_t* neighbours, int64_t count, const double* values,
              int64_t columns, const double* factors, const uint8_t* free, double* out);

// The Gram matrix of hat functions over triangles or of bilinear ones over quads, all of one area.
struct HatProducts {
    Array<int32_t> start, indices;
    Array<double> values;
};
HatProducts hat_products(int64_t vertices, const int32_t* indices, int64_t faces, int corners,
                         double area);

// P' I values (vertices, columns) of a level's values (m, columns), P being the prolongation from
// the coarser level, all of whose faces have so many sides, three or four, and one area, and I the
// Gram matrix of the level's hats.
void restricted(const CageView& coarse, int sides, double area, const double* values,
                int64_t columns, double* out);

// Adds I P hats (m, columns) of hats (vertices, columns), where `free` (which may be null) is not
// 0.
void add_corrected(const CageView& coarse, int sides, double area, const double* hats,
                   int64_t columns, const uint8_t* free, double* out);

// Columns of a sparse matrix: rows `indices` (ascending) and `values` of column i from start[i].
struct SparseColumns {
    std::vector<int32_t> start, indices;
    std::vector<double> values;
};

// I^-1 M' for rows M and the products I of hat functions; entries of a column below 1e-17 of its
// largest are left out. Takes about a millisecond a column; interruptible.
SparseColumns dual_columns(const SparseRows& rows, const SparseRows& products);

}  // namespace henkei
