// Left-looking supernodal Cholesky factorisation, and its triangular solves.
// Ng, Peyton, "Block sparse Cholesky algorithms on advanced uniprocessor computers", SIAM J. Sci.
// Comput. 14, 1993. A panel's values lie row after row, so that a solve reads the factor once
// forwards and once backwards, in the order in which it lies in memory, with one index a row.
#include "cholesky.hpp"

#include <algorithm>
#include <memory>
#include <stdexcept>
#include <string>

#include "kernels.hpp"
#include "panels.hpp"
#include "vectors.hpp"

namespace henkei {

namespace {
constexpr int64_t kBetweenInterrupts = int64_t(1) << 24;  // values

// Panel after panel: what the ones before take off, then the panel by itself.
class Elimination {
  public:
    Elimination(const Panels& panels, double* values)
        : panels_(panels),
          values_(values),
          panel_of_(panels.order.size()),
          local_(panels.order.size()),
          target_(panels.order.size()),
          done_(panels.count(), 0),
          waiting_(panels.count(), kNone),
          next_(panels.count(), kNone),
          scratch_(kTile * kWidest) {
        for (int32_t p = 0; p < panels.count(); ++p) {
            std::fill(panel_of_.begin() + panels.first[p], panel_of_.begin() + panels.first[p + 1],
                      p);
        }
    }

    void run() {
        int64_t since = 0;
        for (int32_t p = 0; p < panels_.count(); ++p) {
            const int32_t first = panels_.first[p], columns = panels_.columns(p);
            for (int32_t c = 0; c < columns; ++c) local_[first + c] = c;
            for (int32_t i = 0; i < panels_.below[p]; ++i) local_[rows(p)[i]] = columns + i;
            for (int32_t from = waiting_[p]; from != kNone;) {
                const int32_t following = next_[from];
                since += take_off(from, p);
                queue(from);
                from = following;
            }
            const int64_t bad = arithmetic_.factor({values_ + panels_.values_at[p], columns},
                                                   columns + panels_.below[p], scratch_.data());
            if (bad >= 0) {
                throw std::domain_error("the pivot of unknown " +
                                        std::to_string(panels_.order[first + bad]) +
                                        " is not positive");
            }
            queue(p);
            since += int64_t(columns) * columns;
            if (since > kBetweenInterrupts) {
                since = 0;
                check_interrupt();
            }
        }
    }

  private:
    const int32_t* rows(int32_t p) const { return panels_.rows.data() + panels_.rows_at[p]; }

    // What a panel takes off from a later one, in the rows that are the later one's columns.
    int64_t take_off(int32_t from, int32_t to) {
        const int32_t depth = panels_.columns(from), begin = done_[from];
        const int32_t rest = panels_.below[from] - begin;
        const int32_t* row = rows(from) + begin;
        int32_t shared = 0;
        while (shared < rest && row[shared] < panels_.first[to + 1]) ++shared;
        for (int32_t i = 0; i < rest; ++i) target_[i] = local_[row[i]];
        arithmetic_.update(
            {values_ + panels_.values_at[from] + int64_t(depth + begin) * depth, depth}, rest,
            shared, {values_ + panels_.values_at[to], panels_.columns(to)}, target_.data(),
            scratch_.data());
        done_[from] += shared;
        return int64_t(rest) * shared;
    }

    // Lets the panel that holds the next row wait for this one.
    void queue(int32_t p) {
        if (done_[p] == panels_.below[p]) return;
        int32_t& head = waiting_[panel_of_[rows(p)[done_[p]]]];
        next_[p] = head;
        head = p;
    }

    static constexpr int32_t kNone = -1;
    const PanelArithmetic& arithmetic_ = panel_arithmetic();
    const Panels& panels_;
    double* values_;
    // The panel of each column; the place of a row in the panel at hand, and of the rows of
    // another.
    std::vector<int32_t> panel_of_, local_, target_;
    std::vector<int32_t> done_;            // rows below a panel that were taken off already
    std::vector<int32_t> waiting_, next_;  // chains of panels that take off from a panel
    std::vector<double> scratch_;
};

}  // namespace

Cholesky::Cholesky(const Pattern& pattern, const double* values, const int32_t* order)
    : panels_(find_panels(pattern, order)), values_(size_t(panels_.values_at.back())) {
    fill(pattern, values);
    Elimination(panels_, values_.data()).run();
    lay_out_panels();
}

// The matrix's lower triangle into the panels.
void Cholesky::fill(const Pattern& pattern, const double* values) {
    std::vector<int32_t> local(pattern.size, 0);
    for (int32_t p = 0; p < panels_.count(); ++p) {
        const int32_t first = panels_.first[p], columns = panels_.columns(p);
        const int32_t* below = panels_.rows.data() + panels_.rows_at[p];
        for (int32_t i = 0; i < panels_.below[p]; ++i) local[below[i]] = i;
        double* panel = values_.data() + panels_.values_at[p];
        for (int32_t c = 0; c < columns; ++c) {
            const int32_t column = panels_.order[first + c];
            for (int32_t e = pattern.start[column]; e < pattern.start[column + 1]; ++e) {
                const int32_t row = panels_.position[pattern.row[e]];
                int64_t i = row - first;
                if (i < c) continue;
                if (i >= columns) {
                    i = columns + local[row];
                    if (local[row] >= panels_.below[p] || below[local[row]] != row) {
                        throw std::invalid_argument("the pattern is not symmetric");
                    }
                }
                panel[i * columns + c] = values[e];
            }
        }
    }
}

// Panels as the solves read them, in the memory of the factored ones.
void Cholesky::lay_out_panels() {
    std::vector<double> panel;
    double* out = values_.data();
    for (int32_t p = 0; p < panels_.count(); ++p) {
        const double* values = values_.data() + panels_.values_at[p];
        panel.assign(values, values + (panels_.values_at[p + 1] - panels_.values_at[p]));
        panels_.values_at[p] = out - values_.data();
        const int64_t columns = panels_.columns(p);
        out = lay_out({panel.data(), columns}, columns + panels_.below[p], out);
    }
    panels_.values_at[panels_.count()] = out - values_.data();
}

void Cholesky::solve(const double* b, double* x, int64_t columns) const {
    const PanelArithmetic& arithmetic = panel_arithmetic();
    const int64_t unknowns = size();
    const auto solve_panel = [&](int32_t p) {
        return SolvePanel{values_.data() + panels_.values_at[p],
                          values_.data() + panels_.values_at[p + 1], panels_.columns(p),
                          panels_.rows.data() + panels_.rows_at[p], panels_.below[p]};
    };
    for (int64_t begin = 0; begin < columns;) {
        const int vectors = columns - begin > kLanes ? 2 : 1;
        const int64_t width = kLanes * vectors, used = std::min(width, columns - begin);
        const std::unique_ptr<double[]> work(new double[size_t(unknowns * width)]);
        double* all = work.get();
        for (int64_t k = 0; k < unknowns; ++k) {
            const double* from = b + panels_.order[k] * columns + begin;
            for (int64_t c = 0; c < used; ++c) all[k * width + c] = from[c];
            for (int64_t c = used; c < width; ++c) all[k * width + c] = 0;
        }
        for (int32_t p = 0; p < panels_.count(); ++p) {
            arithmetic.forward(solve_panel(p), all + panels_.first[p] * width, all, vectors);
        }
        for (int32_t p = panels_.count(); p-- > 0;) {
            arithmetic.backward(solve_panel(p), all + panels_.first[p] * width, all, vectors);
        }
        for (int64_t k = 0; k < unknowns; ++k) {
            double* to = x + panels_.order[k] * columns + begin;
            for (int64_t c = 0; c < used; ++c) to[c] = all[k * width + c];
        }
        begin += used;
        check_interrupt();
    }
}

}  // namespace henkei
