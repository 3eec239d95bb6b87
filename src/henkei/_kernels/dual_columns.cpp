// Columns of I^-1 M' for the Gram matrix I of hat functions and sparse rows M.
// With its diagonal scaled to 1, I has eigenvalues from 1/2 to 2 over triangles and from 1/4 to 9/4
// over quads (Wathen, *Realistic eigenvalue bounds for the Galerkin mass matrix*, 1987), so
// conjugate gradients (Hestenes and Stiefel, 1952) come closer by a factor 3 or 2 a step, and the
// columns die away as fast from ring to ring. A step works only where the column has come to.
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "design.hpp"
#include "kernels.hpp"

namespace henkei {

namespace {

constexpr double kResidual = 1e-16;  // by the length of the right-hand side
constexpr double kAwake = 1e-18;     // by that length, a residual below which a vertex waits,
constexpr double kFront = 0.1;       // as it does below this share of the largest: it would only
                                     // take part in what dies away before it comes so far
constexpr double kKept = 1e-17;      // an entry, by the largest of its column
constexpr int kSteps = 1000;         // far beyond any Gram matrix
constexpr int64_t kBetweenInterrupts = 64;

// Four partial sums, as one would wait for each addition.
double dot(const std::vector<double>& a, const std::vector<double>& b) {
    double sum[4] = {};
    size_t i = 0;
    for (; i + 4 <= a.size(); i += 4) {
        for (size_t k = 0; k < 4; ++k) sum[k] += a[i + k] * b[i + k];
    }
    for (; i < a.size(); ++i) sum[0] += a[i] * b[i];
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

double largest(const std::vector<double>& values) {
    double most = 0;
    for (double x : values) most = std::max(most, std::abs(x));
    return most;
}

// One column after the other. Vertices are numbered anew as the column comes near: those that are
// awake take part, they and their neighbours have rows, and the neighbours of these have numbers.
class LocalSolver {
  public:
    LocalSolver(const SparseRows& matrix) : matrix_(matrix), number_(size_t(matrix.count), -1) {}

    void solve(const int32_t* indices, const double* values, int64_t count) {
        clear();
        for (int64_t k = 0; k < count; ++k) {
            const size_t i = size_t(numbered(indices[k]));
            add_row(i);
            residual_[i] += values[k];
        }
        const double length = std::sqrt(dot(residual_, residual_));
        if (length == 0) return;
        wake(0);
        for (int step = 0; dot(residual_, residual_) > squared(kResidual * length); ++step) {
            if (step == kSteps) throw std::runtime_error("the matrix is not positive definite");
            advance();
            wake(std::max(kAwake * length, kFront * largest(residual_)));
        }
    }

    void append_to(std::vector<int32_t>& indices, std::vector<double>& values) const {
        const double least = kKept * largest(solution_);
        const size_t first = indices.size();
        for (size_t i = 0; i < vertex_.size(); ++i) {
            if (std::abs(solution_[i]) > least) indices.push_back(vertex_[i]);
        }
        std::sort(indices.begin() + int64_t(first), indices.end());
        for (size_t k = first; k < indices.size(); ++k) {
            values.push_back(solution_[size_t(number_[size_t(indices[k])])]);
        }
    }

  private:
    static double squared(double x) { return x * x; }

    void clear() {
        for (int32_t v : vertex_) number_[size_t(v)] = -1;
        vertex_.clear();
        for (auto* numbers : {&residual_, &solution_, &direction_, &change_, &inverse_, &scaled_}) {
            numbers->clear();
        }
        has_row_.clear();
        row_.clear();
        columns_.clear();
        values_.clear();
        start_.assign(1, 0);
        curvature_ = 0;
    }

    int32_t numbered(int32_t vertex) {
        int32_t& number = number_[size_t(vertex)];
        if (number < 0) {
            number = int32_t(vertex_.size());
            vertex_.push_back(vertex);
            for (auto* of : {&residual_, &solution_, &direction_, &change_, &inverse_, &scaled_}) {
                of->push_back(0);
            }
            has_row_.push_back(0);
        }
        return number;
    }

    void add_row(size_t i) {
        if (has_row_[i]) return;
        has_row_[i] = 1;
        row_.push_back(int32_t(i));
        const int32_t v = vertex_[i];
        for (int32_t k = matrix_.start[v]; k < matrix_.start[v + 1]; ++k) {
            columns_.push_back(numbered(matrix_.indices[k]));
            values_.push_back(matrix_.values[k]);
        }
        start_.push_back(columns_.size());
    }

    // Of the vertices with a row, those with a larger residual.
    void wake(double above) {
        const size_t rows = row_.size();
        for (size_t a = 0; a < rows; ++a) {
            const size_t i = size_t(row_[a]);
            if (inverse_[i] > 0 || std::abs(residual_[i]) <= above) continue;
            for (size_t k = start_[a], last = start_[a + 1]; k < last; ++k) {
                const size_t beside = size_t(columns_[k]);
                if (beside == i) inverse_[i] = 1 / values_[k];
                add_row(beside);
            }
            if (!(inverse_[i] > 0)) throw std::runtime_error("the matrix is not positive definite");
        }
    }

    // A step along the scaled residual, made conjugate to the last direction: by their product, as
    // vertices that woke have no part in the shorter formula.
    void advance() {
        for (size_t i = 0; i < vertex_.size(); ++i) scaled_[i] = inverse_[i] * residual_[i];
        const double kept = curvature_ > 0 ? -dot(scaled_, change_) / curvature_ : 0;
        for (size_t i = 0; i < vertex_.size(); ++i) {
            direction_[i] = scaled_[i] + kept * direction_[i];
        }
        // Only rounding may be left, as when the last step ended at the solution: start again.
        if (!(dot(residual_, direction_) > dot(residual_, scaled_) / 2)) direction_ = scaled_;
        for (size_t a = 0; a < row_.size(); ++a) {
            double sum = 0;
            for (size_t k = start_[a]; k < start_[a + 1]; ++k) {
                sum += values_[k] * direction_[size_t(columns_[k])];
            }
            change_[size_t(row_[a])] = sum;
        }
        curvature_ = dot(direction_, change_);
        const double far = dot(residual_, direction_) / curvature_;
        for (size_t i = 0; i < vertex_.size(); ++i) {
            solution_[i] += far * direction_[i];
            residual_[i] -= far * change_[i];
        }
    }

    const SparseRows& matrix_;
    std::vector<int32_t> number_, vertex_;  // of each vertex, -1 without one; and back
    std::vector<double> residual_, scaled_, solution_, direction_, change_;
    double curvature_ = 0;         // of the last direction
    std::vector<double> inverse_;  // of the diagonal where awake, else 0
    std::vector<uint8_t> has_row_;
    std::vector<int32_t> row_;  // the number each row belongs to
    std::vector<size_t> start_;
    std::vector<int32_t> columns_;
    std::vector<double> values_;
};

}  // namespace

SparseColumns dual_columns(const SparseRows& rows, const SparseRows& products) {
    LocalSolver solver(products);
    SparseColumns columns;
    columns.start.push_back(0);
    for (int64_t i = 0; i < rows.count; ++i) {
        if (i % kBetweenInterrupts == 0) check_interrupt();
        const int32_t first = rows.start[i];
        solver.solve(rows.indices + first, rows.values + first, rows.start[i + 1] - first);
        solver.append_to(columns.indices, columns.values);
        if (columns.indices.size() > size_t(INT32_MAX)) {
            throw std::length_error("more entries than indices of 32 bits can number");
        }
        columns.start.push_back(int32_t(columns.indices.size()));
    }
    return columns;
}

}  // namespace henkei
