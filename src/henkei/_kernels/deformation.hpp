// The loops of a frame of a deformation, for n vertices. They end within a tenth of a second for a
// million vertices, so they are not interruptible. Three numbers a vertex, row by row.
#pragma once

#include <cstdint>

namespace henkei {

// Rows of a sparse matrix: columns `indices` and `values` of row i from start[i] to start[i + 1].
struct SparseRows {
    const int32_t *start, *indices;
    const double* values;
    int64_t count;
};

// s_i R_i n_i - n_i for normals n_i, the rotation vector of R_i and the logarithm of s_i being
// sums over h handles with weights (n, h).
void turned_normals(const double* weights, int64_t handles, const double* rotation_vectors,
                    const double* log_scales, const double* normals, int64_t count, double* out);

// out = start + rows * right, for any number of columns; start may be null, or out.
void product(const SparseRows& rows, const double* right, int64_t columns, const double* start,
             double* out);

// Marks of vertices: one that turns on its own, one whose rotation is given. Vertices with the same
// number from 0 on turn as one.
constexpr int32_t kAlone = -1, kGiven = -2;

// Rotations (n, 3, 3) that turn the edges of a vertex at rest best into those after the
// displacement, each counted by its weight if that is positive.
// Beside, by the factor `follow`, they take after the mean of the neighbours' rotations `before`
// (n, 3, 3), which may be null.
void fitted_rotations(const SparseRows& weights, const double* rest, const double* displacement,
                      const int32_t* group, const double* before, double follow, double* rotations);

// Of the energies sum_ij w_ij |(p_i - p_j) - (T_i + T_j)/2 (x_i - x_j)|^2 / 4 and those of normals
// T_i n_i, T = s R: stretch_i = sum_j w_ij ((T_i + T_j)/2 - 1) (x_i - x_j) and
// bent_i = (T_i - 1) n_i. scale may be null, for 1.
void turned_edges(const SparseRows& weights, const double* rest, const double* normals,
                  const double* rotations, const double* scale, double* stretch, double* bent);

// out = start + sum_k c_k basis_k, the k-th of `terms` rows of `count` numbers.
void blended(const double* basis, const double* coefficients, int64_t terms, const double* start,
             int64_t count, double* out);
void blended(const float* basis, const double* coefficients, int64_t terms, const double* start,
             int64_t count, double* out);

// out_i = start_i + weight_i vector
void shifted(const double* start, const double* weight, const double* vector, int64_t count,
             double* out);

}  // namespace henkei
