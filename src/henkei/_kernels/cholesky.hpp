// Sparse Cholesky factorisation in dense panels, and solves with several right-hand sides at once.
#pragma once

#include <vector>

#include "elimination.hpp"
#include "memory.hpp"

namespace henkei {

class Cholesky {
  public:
    // values: of the pattern's entries. order: in which unknowns are eliminated.
    // Throws std::domain_error if a pivot is not positive.
    Cholesky(const Pattern& pattern, const double* values, const int32_t* order);

    // x = A^-1 b for the rows of b, `columns` right-hand sides each; x may be b.
    void solve(const double* b, double* x, int64_t columns) const;

    int64_t size() const { return int64_t(panels_.order.size()); }
    int64_t entries() const { return panels_.values_at.back(); }
    const std::vector<int32_t>& order() const { return panels_.order; }

  private:
    void fill(const Pattern& pattern, const double* values);
    void lay_out_panels();

    Panels panels_;
    Array<double> values_;
};

}  // namespace henkei
