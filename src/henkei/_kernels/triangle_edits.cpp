// Splits, collapses and flips; see triangle_edits.hpp.
#include "triangle_edits.hpp"

#include <array>
#include <utility>

namespace henkei {

TriangleEdits::TriangleEdits(const int32_t* faces, const int32_t* twins, int64_t face_count,
                             int64_t vertices)
    : corner_(faces, faces + 3 * face_count),
      twin_(twins, twins + 3 * face_count),
      leaving_(vertices, -1),
      degree_(vertices, 0),
      line_(3 * face_count) {
    for (int64_t h = 0; h < 3 * face_count; ++h) {
        int32_t& first = leaving_[faces[h]];
        if (first < 0 || twins[h] < 0) first = int32_t(h);
        ++degree_[faces[h]];
        if (twins[h] < 0) ++degree_[target(int32_t(h))];
    }
}

bool TriangleEdits::adjacent(int32_t v, int32_t w) const {
    if (degree_[v] > degree_[w]) std::swap(v, w);
    bool found = false;
    neighbours(v, [&](int32_t u) { found |= u == w; });
    return found;
}

void TriangleEdits::set_line(int32_t h, const Line& line) {
    line_[h] = line;
    if (twin_[h] >= 0) line_[twin_[h]] = line.reversed();
}

int32_t TriangleEdits::new_face(int32_t a, int32_t b, int32_t c) {
    corner_.insert(corner_.end(), {a, b, c});
    twin_.resize(corner_.size(), -1);
    line_.resize(corner_.size());
    return int32_t(corner_.size() - 3);
}

int32_t TriangleEdits::new_vertex() {
    leaving_.push_back(-1);
    degree_.push_back(0);
    return vertex_count() - 1;
}

void TriangleEdits::pair(int32_t g, int32_t h) {
    if (g >= 0) twin_[g] = h;
    if (h >= 0) twin_[h] = g;
}

// Half-edge `to` takes the place of `from` towards the neighbour, and its line.
void TriangleEdits::move_outer(int32_t from, int32_t to) {
    line_[to] = line_[from];
    line_[from] = Line{};
    pair(to, twin_[from]);
}

int32_t TriangleEdits::split(int32_t h, int32_t& continuation) {
    const int32_t t = twin_[h], b = target(h), c = apex(h), m = new_vertex();
    const int32_t e = new_face(m, b, c);
    continuation = e;
    move_outer(next(h), e + 1);
    if (leaving_[b] == next(h)) leaving_[b] = e + 1;
    corner_[next(h)] = m;
    pair(next(h), e + 2);
    leaving_[m] = e;
    ++degree_[c];
    degree_[m] = t < 0 ? 3 : 4;
    if (t < 0) return m;
    const int32_t d = apex(t), k = new_face(b, m, d), last = previous(t);
    move_outer(last, k + 2);
    if (leaving_[d] == last) leaving_[d] = k + 2;
    if (leaving_[b] == t) leaving_[b] = k;
    corner_[t] = m;
    pair(last, k + 1);
    pair(e, k);
    ++degree_[d];
    return m;
}

int32_t TriangleEdits::split_face(int32_t f) {
    const int32_t h = 3 * f, a = corner_[h], b = corner_[h + 1], c = corner_[h + 2];
    const int32_t m = new_vertex(), e = new_face(b, c, m), k = new_face(c, a, m);
    move_outer(h + 1, e);
    if (leaving_[b] == h + 1) leaving_[b] = e;
    move_outer(h + 2, k);
    if (leaving_[c] == h + 2) leaving_[c] = k;
    corner_[h + 2] = m;
    pair(h + 1, e + 2);
    pair(e + 1, k + 2);
    pair(k + 1, h + 2);
    leaving_[m] = h + 2;
    degree_[m] = 3;
    for (const int32_t v : {a, b, c}) ++degree_[v];
    return m;
}

bool TriangleEdits::can_collapse(int32_t h) const {
    int32_t v = origin(h), w = target(h);
    const int32_t t = twin_[h];
    if (t >= 0 && on_boundary(v) && on_boundary(w)) return false;
    for (const int32_t side : {h, t}) {
        if (side < 0) continue;
        const int32_t c = apex(side);
        if (twin_[next(side)] < 0 && twin_[previous(side)] < 0) return false;
        if (!on_boundary(c) && degree(c) <= 3) return false;
    }
    if (degree_[v] > degree_[w]) std::swap(v, w);
    int common = 0;
    neighbours(v, [&](int32_t u) { common += u != w && adjacent(u, w); });
    return common == (t < 0 ? 1 : 2);
}

void TriangleEdits::collapse(int32_t h, int32_t gone) {
    const int32_t kept = gone == origin(h) ? target(h) : origin(h), t = twin_[h];
    const auto vanishes = [&](int32_t e) { return e / 3 == h / 3 || (t >= 0 && e / 3 == t / 3); };
    std::vector<int32_t> star;
    around(gone, [&](int32_t e) { star.push_back(e); });
    for (int32_t e : star) corner_[e] = kept;
    degree_[kept] += degree_[gone] - 2;
    int32_t inner = -1, border = -1;  // half-edges that leave the kept vertex
    for (const int32_t side : {h, t}) {
        if (side < 0) continue;
        const int32_t after = next(side), before = previous(side), c = corner_[before];
        const int32_t a = twin_[after], b = twin_[before];
        if (b >= 0 && line_[after].exists()) line_[b] = line_[after];
        if (a >= 0 && line_[before].exists()) line_[a] = line_[before];
        pair(a, b);
        if (vanishes(leaving_[c])) leaving_[c] = a;
        --degree_[c];
        --degree_[kept];
        inner = b >= 0 ? b : next(a);
        if (b >= 0 && a < 0) border = b;
    }
    for (const int32_t e : {leaving_[kept], leaving_[gone]}) {
        if (!vanishes(e)) (twin_[e] < 0 ? border : inner) = e;
    }
    leaving_[kept] = border >= 0 ? border : inner;
    leaving_[gone] = -1;
    for (const int32_t side : {h, t}) {
        for (int32_t k = 0; side >= 0 && k < 3; ++k) {
            corner_[side / 3 * 3 + k] = -1;
            line_[side / 3 * 3 + k] = Line{};
        }
    }
}

bool TriangleEdits::can_flip(int32_t h) const {
    const int32_t t = twin_[h];
    if (t < 0 || line_[h].exists()) return false;
    const int32_t c = apex(h), d = apex(t);
    if (c == d) return false;
    for (const int32_t v : {origin(h), target(h)}) {
        if (!on_boundary(v) && degree(v) <= 3) return false;
    }
    return !adjacent(c, d);
}

void TriangleEdits::flip(int32_t h) {
    const int32_t t = twin_[h], f = h / 3 * 3, g = t / 3 * 3;
    const std::array<int32_t, 4> from = {previous(t), next(h), previous(h), next(t)};
    const std::array<int32_t, 4> to = {f, f + 1, g, g + 1};
    const int32_t a = origin(h), b = target(h), c = apex(h), d = apex(t);
    const std::array<int32_t, 4> start = {d, b, c, a};
    std::array<int32_t, 4> neighbour, leaving;
    std::array<Line, 4> line;
    for (int k = 0; k < 4; ++k) {
        neighbour[k] = twin_[from[k]];
        line[k] = line_[from[k]];
        leaving[k] = leaving_[start[k]];
    }
    for (int k = 0; k < 4; ++k) {
        if (leaving[k] == from[k]) leaving_[start[k]] = to[k];
    }
    if (leaving[1] == t) leaving_[b] = f + 1;
    if (leaving[3] == h) leaving_[a] = g + 1;
    const std::array<int32_t, 3> one = {d, b, c}, other = {c, a, d};
    for (int k = 0; k < 3; ++k) corner_[f + k] = one[k], corner_[g + k] = other[k];
    for (int k = 0; k < 4; ++k) {
        line_[to[k]] = line[k];
        pair(to[k], neighbour[k]);
        if (neighbour[k] < 0) twin_[to[k]] = -1;
    }
    line_[f + 2] = line_[g + 2] = Line{};
    pair(f + 2, g + 2);
    --degree_[a];
    --degree_[b];
    ++degree_[c];
    ++degree_[d];
}

}  // namespace henkei
