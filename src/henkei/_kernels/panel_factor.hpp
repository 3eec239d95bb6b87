// Dense steps of the factorisation. Included by panels.cpp, once for each set of instructions.

HENKEI_INLINE Four all_of(double value) {
#if defined(__GNUC__)
    return Four{value, value, value, value};
#else
    return {{value, value, value, value}};
#endif
}
HENKEI_INLINE Four& four(double* p) {
    return *reinterpret_cast<Four*>(p);
}
HENKEI_INLINE const Four& four(const double* p) {
    return *reinterpret_cast<const Four*>(p);
}

// packed[k][j] = rows[j][k] for k < depth, kTile columns, zeros where there are fewer rows.
static void pack(const PanelRows& rows, int64_t depth, int64_t count, double* packed) {
    for (int64_t j = 0; j < kTile; ++j) {
        if (j < count) {
            const double* row = rows.row(j);
            for (int64_t k = 0; k < depth; ++k) packed[kTile * k + j] = row[k];
        } else {
            for (int64_t k = 0; k < depth; ++k) packed[kTile * k + j] = 0;
        }
    }
}

// Four rows of kTile sums.
struct Tile {
    Four row[4][2];
    double* values(int64_t r) { return reinterpret_cast<double*>(row[r]); }
};

// The sums over k < depth of row[r][k] packed[k][:].
HENKEI_INLINE void multiply(const double* const row[4], const double* packed, int64_t depth,
                            Tile& sums) {
    Four a0 = all_of(0), a1 = a0, b0 = a0, b1 = a0, c0 = a0, c1 = a0, d0 = a0, d1 = a0;
    const double *a = row[0], *b = row[1], *c = row[2], *d = row[3];
    for (int64_t k = 0; k < depth; ++k) {
        const Four low = four(packed + kTile * k), high = four(packed + kTile * k + 4);
        const Four ak = all_of(a[k]), bk = all_of(b[k]), ck = all_of(c[k]), dk = all_of(d[k]);
        a0 += ak * low, a1 += ak * high;
        b0 += bk * low, b1 += bk * high;
        c0 += ck * low, c1 += ck * high;
        d0 += dk * low, d1 += dk * high;
    }
    sums.row[0][0] = a0, sums.row[0][1] = a1, sums.row[1][0] = b0, sums.row[1][1] = b1;
    sums.row[2][0] = c0, sums.row[2][1] = c1, sums.row[3][0] = d0, sums.row[3][1] = d1;
}

static int64_t at_most(int64_t value, int64_t most) {
    return value < most ? value : most;
}

static void update(const PanelRows& source, int64_t rows, int64_t columns, const PanelRows& target,
                   const int32_t* at, double* packed) {
    const int64_t depth = source.columns;
    for (int64_t j = 0; j < columns; j += kTile) {
        const int64_t width = at_most(kTile, columns - j);
        const bool whole = width == kTile && at[j + kTile - 1] - at[j] == kTile - 1;
        pack({source.row(j), depth}, depth, width, packed);
        for (int64_t i = j; i < rows; i += 4) {
            const int64_t height = at_most(4, rows - i);
            const double* row[4];
            for (int64_t r = 0; r < 4; ++r) row[r] = source.row(i + at_most(r, height - 1));
            Tile sums;
            multiply(row, packed, depth, sums);
            for (int64_t r = 0; r < height; ++r) {
                double* out = target.row(at[i + r]);
                if (whole) {
                    four(out + at[j]) -= sums.row[r][0];
                    four(out + at[j] + 4) -= sums.row[r][1];
                } else {
                    const double* sum = sums.values(r);
                    for (int64_t c = 0; c < width; ++c) out[at[j + c]] -= sum[c];
                }
            }
        }
    }
}

// Columns j to j + width of the factor's square; the reciprocals of the pivots stay on its
// diagonal. What the columns before take off is taken off already.
static int64_t factor_square(const PanelRows& panel, int64_t j, int64_t width) {
    for (int64_t c = j; c < j + width; ++c) {
        double pivot = panel.row(c)[c];
        for (int64_t k = j; k < c; ++k) pivot -= panel.row(c)[k] * panel.row(c)[k];
        if (!(pivot > 0) || !(pivot < INFINITY)) return c;
        const double scale = 1 / std::sqrt(pivot);
        panel.row(c)[c] = scale;
        for (int64_t i = c + 1; i < j + width; ++i) {
            double value = panel.row(i)[c];
            for (int64_t k = j; k < c; ++k) value -= panel.row(i)[k] * panel.row(c)[k];
            panel.row(i)[c] = value * scale;
        }
    }
    return -1;
}

// Four rows of the columns, less what the columns before take off.
HENKEI_INLINE void less_before(const PanelRows& panel, int64_t i, int64_t height, int64_t j,
                               int64_t width, const double* packed, Tile& rest) {
    const double* row[4];
    for (int64_t r = 0; r < 4; ++r) row[r] = panel.row(i + at_most(r, height - 1));
    multiply(row, packed, j, rest);
    for (int64_t r = 0; r < 4; ++r) {
        double* value = rest.values(r);
        for (int64_t c = 0; c < width; ++c) value[c] = row[r][j + c] - value[c];
    }
}

HENKEI_INLINE void store(const PanelRows& panel, int64_t i, int64_t height, int64_t j,
                         int64_t width, Tile& tile) {
    for (int64_t r = 0; r < height; ++r) {
        double* out = panel.row(i + r) + j;
        for (int64_t c = 0; c < width; ++c) out[c] = tile.values(r)[c];
    }
}

static int64_t factor(const PanelRows& panel, int64_t rows, double* packed) {
    for (int64_t j = 0; j < panel.columns; j += kTile) {
        const int64_t width = at_most(kTile, panel.columns - j);
        pack({panel.row(j), panel.columns}, j, width, packed);
        Tile tile;
        for (int64_t i = j; i < j + width; i += 4) {
            const int64_t height = at_most(4, j + width - i);
            less_before(panel, i, height, j, width, packed, tile);
            store(panel, i, height, j, width, tile);
        }
        const int64_t bad = factor_square(panel, j, width);
        if (bad >= 0) return bad;

        // Rows below: solved with the square, in the form of a unit triangle times a diagonal.
        double unit[kTile][kTile], scale[kTile];
        for (int64_t c = 0; c < kTile; ++c) {
            scale[c] = c < width ? panel.row(j + c)[j + c] : 0;
            for (int64_t l = 0; l < kTile; ++l) {
                unit[c][l] = c < l && l < width ? panel.row(j + l)[j + c] * scale[c] : 0;
            }
        }
        for (int64_t i = j + width; i < rows; i += 4) {
            const int64_t height = at_most(4, rows - i);
            less_before(panel, i, height, j, width, packed, tile);
            HENKEI_UNROLL for (int c = 0; c < kTile; ++c) {
                HENKEI_UNROLL for (int r = 0; r < 4; ++r) {
                    const Four by = all_of(tile.values(r)[c]);
                    tile.row[r][0] -= by * four(unit[c]);
                    tile.row[r][1] -= by * four(unit[c] + 4);
                }
            }
            HENKEI_UNROLL for (int r = 0; r < 4; ++r) {
                tile.row[r][0] = tile.row[r][0] * four(scale);
                tile.row[r][1] = tile.row[r][1] * four(scale + 4);
            }
            store(panel, i, height, j, width, tile);
        }
    }
    return -1;
}
