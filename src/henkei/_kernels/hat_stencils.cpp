// Inner products of a level's shape with the hats of the level before (section 3.2 and eq. 8 of
// Takahashi, *Designing subdivision surfaces via multiresolution-based local filtering*, 2000), and
// their transpose, face by face of that coarser level. On a line of length h that is halved, values
// at its first end, its middle and its last end make
//
//     h / 24 (5 6 1)    with the hat at the first end,
//     h / 24 (1 6 5)    with that at the last,
//
// on a quad both ways one after the other, and on a triangle area / 96 (s + 5 v_i + 6 sum of the m
// beside corner i) for values v at its corners and m at its midpoints, s = sum v + 4 sum m.
#include <vector>

#include "design.hpp"
#include "vectorised.hpp"
#include "vectors.hpp"

namespace henkei {

namespace {

// A row is a number of one column, or three columns at once: four numbers, the last meaningless.
using Points = AlignedFour;
template <class Row>
constexpr int kWidth = int(sizeof(Row) / sizeof(double));
template <class Row>
constexpr int kColumns = kWidth<Row> == 1 ? 1 : 3;

HENKEI_INLINE double times(double factor, double row) {
    return factor * row;
}

HENKEI_INLINE Points times(double factor, const Points& row) {
    const Points factors = {factor, factor, factor, factor};
    return factors * row;
}

HENKEI_INLINE void read(const double* from, double& row) {
    row = *from;
}

HENKEI_INLINE void read(const double* from, Points& row) {
    row = *reinterpret_cast<const Four*>(from);
}

// Adds the columns of a row.
HENKEI_INLINE void add(double row, double* to) {
    *to += row;
}

HENKEI_INLINE void add(const Points& row, double* to) {
    const double sum[] = {to[0] + row[0], to[1] + row[1], to[2] + row[2]};  // all, then stored
    for (int c = 0; c < 3; ++c) to[c] = sum[c];
}

// Adds all its numbers.
HENKEI_INLINE void add_whole(double row, double* to) {
    *to += row;
}

HENKEI_INLINE void add_whole(const Points& row, double* to) {
    *reinterpret_cast<Four*>(to) += row;
}

// Rows that start so many numbers apart. The last has no fourth number, but its copy has.
template <class Row>
struct Rows {
    HENKEI_INLINE Rows(const double* numbers, int64_t stride, int64_t count)
        : numbers(numbers), stride(stride), last(count - 1) {
        for (int c = 0; count > 0 && c < kColumns<Row>; ++c) copy[c] = numbers[stride * last + c];
    }
    HENKEI_INLINE Row operator[](int64_t i) const {
        Row row;
        read(i == last ? copy : numbers + stride * i, row);
        return row;
    }
    const double* numbers;
    int64_t stride, last;
    double copy[4] = {};
};

// The vertices of a refined face.
template <int Sides>
struct Places {
    HENKEI_INLINE Places(const CageView& coarse, int64_t f)
        : corners(coarse.indices + Sides * f),
          edges(coarse.corner_edges + Sides * f),
          first_middle(coarse.vertices),
          centre(coarse.vertices + coarse.edge_count + f) {}
    HENKEI_INLINE int64_t corner(int i) const { return corners[i]; }
    HENKEI_INLINE int64_t middle(int i) const { return first_middle + edges[i]; }
    const int32_t *corners, *edges;
    int64_t first_middle, centre;
};

// 5 first + 6 middle + last, and first + 6 middle + 5 last.
template <class Row>
HENKEI_INLINE void to_ends(const Row& first, const Row& middle, const Row& last, Row& at_first,
                           Row& at_last) {
    const Row all = first + last + times(6, middle);
    at_first = all + times(4, first);
    at_last = all + times(4, last);
}

// The transpose: 5 first + last, 6 (first + last) and first + 5 last.
template <class Row>
HENKEI_INLINE void from_ends(const Row& first, const Row& last, Row (&to)[3]) {
    const Row both = first + last;
    to[0] = both + times(4, first);
    to[1] = times(6, both);
    to[2] = both + times(4, last);
}

// What each corner of a face receives.
template <class Row>
HENKEI_INLINE void to_corners(const Places<3>& at, const Rows<Row>& values, Row (&to)[3]) {
    const Row a = values[at.corner(0)], b = values[at.corner(1)], c = values[at.corner(2)];
    const Row ab = values[at.middle(0)], bc = values[at.middle(1)], ca = values[at.middle(2)];
    const Row all = a + b + c + times(4, ab + bc + ca);
    to[0] = all + times(5, a) + times(6, ab + ca);
    to[1] = all + times(5, b) + times(6, ab + bc);
    to[2] = all + times(5, c) + times(6, bc + ca);
}

template <class Row>
HENKEI_INLINE void to_corners(const Places<4>& at, const Rows<Row>& values, Row (&to)[4]) {
    const Row a = values[at.corner(0)], b = values[at.corner(1)];
    const Row c = values[at.corner(2)], d = values[at.corner(3)];
    Row first[3], last[3];
    to_ends(a, values[at.middle(0)], b, first[0], last[0]);
    to_ends(values[at.middle(3)], values[at.centre], values[at.middle(1)], first[1], last[1]);
    to_ends(d, values[at.middle(2)], c, first[2], last[2]);
    to_ends(first[0], first[1], first[2], to[0], to[3]);
    to_ends(last[0], last[1], last[2], to[1], to[2]);
}

// Calls receive(vertex, row) for each vertex of a refined face.
template <class Row, class Receive>
HENKEI_INLINE void from_corners(const Places<3>& at, const Row (&hats)[3], Receive receive) {
    const Row &a = hats[0], &b = hats[1], &c = hats[2];
    const Row all = a + b + c, more = times(4, all);
    receive(at.corner(0), all + times(5, a));
    receive(at.corner(1), all + times(5, b));
    receive(at.corner(2), all + times(5, c));
    receive(at.middle(0), more + times(6, a + b));
    receive(at.middle(1), more + times(6, b + c));
    receive(at.middle(2), more + times(6, c + a));
}

template <class Row, class Receive>
HENKEI_INLINE void from_corners(const Places<4>& at, const Row (&hats)[4], Receive receive) {
    Row first[3], last[3], to[3][3];
    from_ends(hats[0], hats[3], first);
    from_ends(hats[1], hats[2], last);
    for (int i = 0; i < 3; ++i) from_ends(first[i], last[i], to[i]);
    receive(at.corner(0), to[0][0]);
    receive(at.middle(0), to[0][1]);
    receive(at.corner(1), to[0][2]);
    receive(at.middle(3), to[1][0]);
    receive(at.centre, to[1][1]);
    receive(at.middle(1), to[1][2]);
    receive(at.corner(3), to[2][0]);
    receive(at.middle(2), to[2][1]);
    receive(at.corner(2), to[2][2]);
}

template <int Sides>
constexpr double kParts = Sides == 3 ? 96 : 24 * 24;

template <class Row, int Sides>
HENKEI_INLINE void restrict_rows(const CageView coarse, double area, const double* values,
                                 int64_t stride, double* out) {
    const int64_t faces = coarse.corners / Sides, centres = Sides == 4 ? faces : 0;
    const Rows<Row> rows(values, stride, coarse.vertices + coarse.edge_count + centres);
    std::vector<double> sums(size_t(kWidth<Row> * coarse.vertices), 0.0);
    double* sum = sums.data();
    for (int64_t f = 0; f < faces; ++f) {
        const Places<Sides> at(coarse, f);
        Row to[Sides];
        to_corners(at, rows, to);
        for (int i = 0; i < Sides; ++i) add_whole(to[i], sum + kWidth<Row> * at.corner(i));
    }
    const double part = area / kParts<Sides>;
    for (int64_t i = 0; i < coarse.vertices; ++i, out += stride, sum += kWidth<Row>) {
        for (int c = 0; c < kColumns<Row>; ++c) out[c] = part * sum[c];
    }
}

template <class Row, int Sides>
HENKEI_INLINE void correct_rows(const CageView coarse, double area, const double* hats,
                                int64_t stride, const uint8_t* free, double* out) {
    const Rows<Row> rows(hats, stride, coarse.vertices);
    const double part = area / kParts<Sides>;
    for (int64_t f = 0; f < coarse.corners / Sides; ++f) {
        const Places<Sides> at(coarse, f);
        Row from[Sides];
        for (int i = 0; i < Sides; ++i) from[i] = times(part, rows[at.corner(i)]);
        from_corners(at, from, [&](int64_t vertex, const Row& row) {
            if (free == nullptr || free[vertex]) add(row, out + stride * vertex);
        });
    }
}

HENKEI_VECTORISED
void restrict_points(const CageView& coarse, int sides, double area, const double* values,
                     double* out) {
    if (sides == 3) restrict_rows<Points, 3>(coarse, area, values, 3, out);
    if (sides == 4) restrict_rows<Points, 4>(coarse, area, values, 3, out);
}

HENKEI_VECTORISED
void correct_points(const CageView& coarse, int sides, double area, const double* hats,
                    const uint8_t* free, double* out) {
    if (sides == 3) correct_rows<Points, 3>(coarse, area, hats, 3, free, out);
    if (sides == 4) correct_rows<Points, 4>(coarse, area, hats, 3, free, out);
}

}  // namespace

void restricted(const CageView& coarse, int sides, double area, const double* values,
                int64_t columns, double* out) {
    if (columns == 3) return restrict_points(coarse, sides, area, values, out);
    for (int64_t c = 0; c < columns; ++c) {
        if (sides == 3) restrict_rows<double, 3>(coarse, area, values + c, columns, out + c);
        if (sides == 4) restrict_rows<double, 4>(coarse, area, values + c, columns, out + c);
    }
}

void add_corrected(const CageView& coarse, int sides, double area, const double* hats,
                   int64_t columns, const uint8_t* free, double* out) {
    if (columns == 3) return correct_points(coarse, sides, area, hats, free, out);
    for (int64_t c = 0; c < columns; ++c) {
        if (sides == 3) correct_rows<double, 3>(coarse, area, hats + c, columns, free, out + c);
        if (sides == 4) correct_rows<double, 4>(coarse, area, hats + c, columns, free, out + c);
    }
}

}  // namespace henkei
