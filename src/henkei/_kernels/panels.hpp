// The arithmetic of a sparse Cholesky factor, panel by panel; see panels.cpp.
#pragma once

#include <cstdint>

namespace henkei {

constexpr int kTile = 8;     // rows or columns that are worked on together
constexpr int kWidest = 64;  // columns of a panel

// While it is factored, a panel is a matrix of rows that follow each other in memory.
struct PanelRows {
    double* values;
    int64_t columns;
    double* row(int64_t i) const { return values + i * columns; }
};

// Rows are solved in groups of 8, and what is left in groups of 4, 2 and 1.
inline int64_t group_size(int64_t rows) {
    return rows >= 8 ? 8 : rows >= 4 ? 4 : rows >= 2 ? 2 : 1;
}

// For solving, a panel is laid out group after group, as the solve reads it: of a group the values
// of one column, then of the next. Groups of the square's rows end with their own square.
struct SolvePanel {
    const double *begin, *end;
    int64_t columns;
    const int32_t* below;
    int64_t below_count;
};

// Lays a factored panel out for solving; returns the end of what is written.
double* lay_out(const PanelRows& panel, int64_t rows, double* out);

// Chosen once, for the instructions that the processor has.
struct PanelArithmetic {
    // target[at[i]][at[j]] -= sum_k source[i][k] source[j][k], for i < rows, j < columns, at least
    // where i >= j. scratch: kTile * kWidest values.
    void (*update)(const PanelRows& source, int64_t rows, int64_t columns, const PanelRows& target,
                   const int32_t* at, double* scratch);
    // Factors the panel in place; the diagonal is left as its reciprocals. Returns the first
    // column with a pivot that is not positive, or -1. scratch: kTile * kWidest values.
    int64_t (*factor)(const PanelRows& panel, int64_t rows, double* scratch);
    // Solve with the panel, for one or two vectors of right-hand sides an unknown. x: at the
    // panel's first unknown, all: at the first of all.
    void (*forward)(const SolvePanel& panel, double* x, double* all, int vectors);
    void (*backward)(const SolvePanel& panel, double* x, const double* all, int vectors);
};

const PanelArithmetic& panel_arithmetic();

}  // namespace henkei
