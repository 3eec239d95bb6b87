// Triangular solves with a panel. Included by panels.cpp, once for each set of instructions.

// y[r] -= sum_j group[j][r] x[j]
template <int Rows, int Vectors, int Stride>
HENKEI_INLINE void subtract(const double* group, int64_t columns, const double* x,
                            double* const* y) {
    Four sum[Rows][Vectors];
    HENKEI_UNROLL for (int r = 0; r < Rows; ++r) {
        HENKEI_UNROLL for (int v = 0; v < Vectors; ++v) sum[r][v] = four(y[r] + kLanes * v);
    }
    for (int64_t j = 0; j < columns; ++j) {
        Four xj[Vectors];
        HENKEI_UNROLL for (int v = 0; v < Vectors; ++v) {
            xj[v] = four(x + kLanes * (Vectors * j + v));
        }
        HENKEI_UNROLL for (int r = 0; r < Rows; ++r) {
            const Four value = all_of(group[Stride * j + r]);
            HENKEI_UNROLL for (int v = 0; v < Vectors; ++v) sum[r][v] -= value * xj[v];
        }
    }
    HENKEI_UNROLL for (int r = 0; r < Rows; ++r) {
        HENKEI_UNROLL for (int v = 0; v < Vectors; ++v) four(y[r] + kLanes * v) = sum[r][v];
    }
}

// x[j] -= sum_r group[j][r] y[r]. From the last column to the first, so that a factor is read
// backwards without a break: what comes next is then in the cache, and time a third.
template <int Rows, int Vectors, int Stride>
HENKEI_INLINE void subtract_transposed(const double* group, int64_t columns, double* x,
                                       const double* const* y) {
    Four yr[Rows][Vectors];
    HENKEI_UNROLL for (int r = 0; r < Rows; ++r) {
        HENKEI_UNROLL for (int v = 0; v < Vectors; ++v) yr[r][v] = four(y[r] + kLanes * v);
    }
    for (int64_t j = columns; j-- > 0;) {
        HENKEI_UNROLL for (int v = 0; v < Vectors; ++v) {
            double* xj = x + kLanes * (Vectors * j + v);
            Four even = four(xj), odd = all_of(0);
            HENKEI_UNROLL for (int r = 0; r < Rows; r += 2) {
                even -= all_of(group[Stride * j + r]) * yr[r][v];
                if (r + 1 < Rows) odd -= all_of(group[Stride * j + r + 1]) * yr[r + 1][v];
            }
            four(xj) = Rows > 1 ? even + odd : even;
        }
    }
}

// A group of 8 rows with two vectors each is too much for the registers at once.
template <int Rows, int Vectors>
HENKEI_INLINE void subtract_group(const double* group, int64_t columns, const double* x,
                                  double* const* y) {
    if constexpr (Rows * Vectors > 8) {
        subtract<Rows / 2, Vectors, Rows>(group, columns, x, y);
        subtract<Rows / 2, Vectors, Rows>(group + Rows / 2, columns, x, y + Rows / 2);
    } else {
        subtract<Rows, Vectors, Rows>(group, columns, x, y);
    }
}

template <int Rows, int Vectors>
HENKEI_INLINE void subtract_group_transposed(const double* group, int64_t columns, double* x,
                                             const double* const* y) {
    if constexpr (Rows * Vectors > 8) {
        subtract_transposed<Rows / 2, Vectors, Rows>(group, columns, x, y);
        subtract_transposed<Rows / 2, Vectors, Rows>(group + Rows / 2, columns, x, y + Rows / 2);
    } else {
        subtract_transposed<Rows, Vectors, Rows>(group, columns, x, y);
    }
}

// Rows i to i + Rows of the panel's square.
template <int Rows, int Vectors>
HENKEI_INLINE const double* square_forward(const double* group, int64_t i, double* x) {
    double* y[Rows];
    HENKEI_UNROLL for (int r = 0; r < Rows; ++r) y[r] = x + kLanes * Vectors * (i + r);
    if (i > 0) subtract_group<Rows, Vectors>(group, i, x, y);
    group += Rows * i;
    HENKEI_UNROLL for (int v = 0; v < Vectors; ++v) {
        Four sum[Rows];
        HENKEI_UNROLL for (int r = 0; r < Rows; ++r) sum[r] = four(y[r] + kLanes * v);
        HENKEI_UNROLL for (int c = 0; c < Rows; ++c) {
            sum[c] = sum[c] * all_of(group[Rows * c + c]);
            HENKEI_UNROLL for (int r = c + 1; r < Rows; ++r) {
                sum[r] -= all_of(group[Rows * c + r]) * sum[c];
            }
        }
        HENKEI_UNROLL for (int r = 0; r < Rows; ++r) four(y[r] + kLanes * v) = sum[r];
    }
    return group + Rows * Rows;
}

template <int Rows, int Vectors>
HENKEI_INLINE const double* square_backward(const double* end, int64_t i, double* x) {
    const double* group = end - Rows * Rows;
    double* y[Rows];
    HENKEI_UNROLL for (int r = 0; r < Rows; ++r) y[r] = x + kLanes * Vectors * (i + r);
    HENKEI_UNROLL for (int v = 0; v < Vectors; ++v) {
        Four sum[Rows];
        HENKEI_UNROLL for (int r = 0; r < Rows; ++r) sum[r] = four(y[r] + kLanes * v);
        HENKEI_UNROLL for (int r = Rows - 1; r >= 0; --r) {
            sum[r] = sum[r] * all_of(group[Rows * r + r]);
            HENKEI_UNROLL for (int c = 0; c < r; ++c) {
                sum[c] -= all_of(group[Rows * c + r]) * sum[r];
            }
        }
        HENKEI_UNROLL for (int r = 0; r < Rows; ++r) four(y[r] + kLanes * v) = sum[r];
    }
    group -= Rows * i;
    if (i > 0) subtract_group_transposed<Rows, Vectors>(group, i, x, y);
    return group;
}

template <int Rows, int Vectors>
HENKEI_INLINE const double* below_forward(const double* group, int64_t columns, const int32_t* row,
                                          const double* x, double* all) {
    double* y[Rows];
    HENKEI_UNROLL for (int r = 0; r < Rows; ++r) {
        y[r] = all + kLanes * Vectors * int64_t(row[r]);
    }
    subtract_group<Rows, Vectors>(group, columns, x, y);
    return group + Rows * columns;
}

template <int Rows, int Vectors>
HENKEI_INLINE const double* below_backward(const double* end, int64_t columns, const int32_t* row,
                                           double* x, const double* all) {
    const double* y[Rows];
    HENKEI_UNROLL for (int r = 0; r < Rows; ++r) {
        y[r] = all + kLanes * Vectors * int64_t(row[r]);
    }
    subtract_group_transposed<Rows, Vectors>(end - Rows * columns, columns, x, y);
    return end - Rows * columns;
}

template <int Vectors>
HENKEI_INLINE void forward(const SolvePanel& panel, double* x, double* all) {
    const double* values = panel.begin;
    const int64_t columns = panel.columns;
    int64_t i = 0;
    for (; i + 8 <= columns; i += 8) values = square_forward<8, Vectors>(values, i, x);
    if (columns & 4) values = square_forward<4, Vectors>(values, i, x), i += 4;
    if (columns & 2) values = square_forward<2, Vectors>(values, i, x), i += 2;
    if (columns & 1) values = square_forward<1, Vectors>(values, i, x);
    const int32_t* row = panel.below;
    const int32_t* whole = row + panel.below_count / 8 * 8;
    for (; row < whole; row += 8) values = below_forward<8, Vectors>(values, columns, row, x, all);
    if (panel.below_count & 4) {
        values = below_forward<4, Vectors>(values, columns, row, x, all), row += 4;
    }
    if (panel.below_count & 2) {
        values = below_forward<2, Vectors>(values, columns, row, x, all), row += 2;
    }
    if (panel.below_count & 1) below_forward<1, Vectors>(values, columns, row, x, all);
}

template <int Vectors>
HENKEI_INLINE void backward(const SolvePanel& panel, double* x, const double* all) {
    const double* end = panel.end;
    const int64_t columns = panel.columns;
    const int32_t* row = panel.below + panel.below_count;
    if (panel.below_count & 1) {
        row -= 1, end = below_backward<1, Vectors>(end, columns, row, x, all);
    }
    if (panel.below_count & 2) {
        row -= 2, end = below_backward<2, Vectors>(end, columns, row, x, all);
    }
    if (panel.below_count & 4) {
        row -= 4, end = below_backward<4, Vectors>(end, columns, row, x, all);
    }
    while (row > panel.below) {
        row -= 8, end = below_backward<8, Vectors>(end, columns, row, x, all);
    }
    int64_t i = columns;
    if (columns & 1) i -= 1, end = square_backward<1, Vectors>(end, i, x);
    if (columns & 2) i -= 2, end = square_backward<2, Vectors>(end, i, x);
    if (columns & 4) i -= 4, end = square_backward<4, Vectors>(end, i, x);
    while (i > 0) i -= 8, end = square_backward<8, Vectors>(end, i, x);
}

static void solve_forward(const SolvePanel& panel, double* x, double* all, int vectors) {
    if (vectors == 1) {
        forward<1>(panel, x, all);
    } else {
        forward<2>(panel, x, all);
    }
}

static void solve_backward(const SolvePanel& panel, double* x, const double* all, int vectors) {
    if (vectors == 1) {
        backward<1>(panel, x, all);
    } else {
        backward<2>(panel, x, all);
    }
}
