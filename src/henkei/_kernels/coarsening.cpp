// Half-edge collapses in independent rounds; see coarsening.hpp.
#include "coarsening.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace henkei {

namespace {
constexpr size_t kMostFaces = 14;  // around a vertex after a collapse
}

bool upright_face(const Vec& a, const Vec& b, const Vec& c) {
    const Vec e = b - a, d = c - a;
    const double size = std::sqrt(std::max(dot(e, e), dot(d, d)));
    return turn(a, b, c) > 1e-14 * size + 1e-6 * size * size;
}

Coarsening::Coarsening(const int32_t* faces, int64_t face_count, int64_t vertices)
    : corner_(faces, faces + 3 * face_count),
      star_(vertices),
      alive_vertex_(vertices, 1),
      alive_face_(face_count, 1),
      left_(vertices) {
    for (int64_t h = 0; h < 3 * face_count; ++h) star_[faces[h]].push_back(int32_t(h / 3));
}

bool Coarsening::has(int64_t face, int32_t v) const {
    return corner_[3 * face] == v || corner_[3 * face + 1] == v || corner_[3 * face + 2] == v;
}

std::vector<int32_t> Coarsening::ring(int32_t v) const {
    std::vector<int32_t> found;
    for (int32_t f : star_[v]) {
        for (int k = 0; k < 3; ++k) {
            if (corner_[3 * int64_t(f) + k] == v) {
                found.push_back(corner_[3 * int64_t(f) + (k + 1) % 3]);
            }
        }
    }
    return found;
}

int64_t Coarsening::coarsen(const std::vector<Vec>& sphere, const Vec* rest,
                            const uint8_t* frozen) {
    round_start_.push_back(history_.size());
    // Vertices by the size of what they hold: small flat stars first.
    std::vector<int32_t> order;
    std::vector<double> cost(star_.size(), 0.0);
    for (size_t v = 0; v < star_.size(); ++v) {
        if (!alive_vertex_[v] || frozen[v]) continue;
        Vec normal = {0, 0, 0}, apex = {0, 0, 0};
        double area = 0;
        for (int32_t f : star_[v]) {
            const int32_t* c = &corner_[3 * int64_t(f)];
            const Vec n = cross(rest[c[1]] - rest[c[0]], rest[c[2]] - rest[c[0]]);
            normal = normal + n;
            area += length(n);
            for (int k = 0; k < 3; ++k) apex = apex + (rest[c[k]] - rest[v]);
        }
        const double bend = area > 0 ? 1 - length(normal) / area : 0;
        cost[v] = area * (0.02 + bend);
        order.push_back(int32_t(v));
    }
    std::sort(order.begin(), order.end(),
              [&](int32_t a, int32_t b) { return cost[a] != cost[b] ? cost[a] < cost[b] : a < b; });
    order.resize(order.size() * 3 / 4);
    std::vector<uint8_t> locked(star_.size(), 0);
    const size_t before = history_.size();
    for (int32_t v : order) {
        if (locked[v]) continue;
        std::vector<int32_t> around = ring(v);
        std::sort(around.begin(), around.end(), [&](int32_t a, int32_t b) {
            const double da = length(rest[a] - rest[v]), db = length(rest[b] - rest[v]);
            return da != db ? da < db : a < b;
        });
        for (int32_t onto : around) {
            if (!collapse(v, onto, sphere)) continue;
            for (int32_t r : around) locked[r] = 1;
            break;
        }
    }
    const int64_t taken = int64_t(history_.size() - before);
    left_ -= taken;
    if (taken == 0) round_start_.pop_back();
    return taken;
}

bool Coarsening::collapse(int32_t v, int32_t onto, const std::vector<Vec>& sphere) {
    if (star_[v].size() + star_[onto].size() > kMostFaces + 4) return false;
    // Link condition: v and onto have just the two corners opposite to their edge in common.
    std::vector<int32_t> a = ring(v), b = ring(onto), both;
    std::sort(a.begin(), a.end());
    std::sort(b.begin(), b.end());
    std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(both));
    if (both.size() != 2 || left_ <= 4) return false;
    if (star_[both[0]].size() <= 3 || star_[both[1]].size() <= 3) return false;
    Collapse c{v, onto, {-1, -1}, {}, star_[onto]};
    int gone = 0;
    for (int32_t f : star_[v]) {
        if (has(f, onto)) {
            if (gone < 2) c.gone[gone] = f;
            ++gone;
            continue;
        }
        Vec p[3];
        for (int k = 0; k < 3; ++k) {
            const int32_t w = corner_[3 * int64_t(f) + k];
            p[k] = sphere[w == v ? onto : w];
            if (w == v) c.moved.push_back(int32_t(3 * f + k));
        }
        if (!upright_face(p[0], p[1], p[2])) return false;
    }
    if (gone != 2) return false;
    for (int32_t h : c.moved) {
        corner_[h] = onto;
        star_[onto].push_back(h / 3);
    }
    for (int32_t f : c.gone) {
        alive_face_[f] = 0;
        for (int k = 0; k < 3; ++k) {
            const int32_t w = corner_[3 * int64_t(f) + k];
            if (w == v) continue;
            auto& s = star_[w];
            s.erase(std::find(s.begin(), s.end(), f));
        }
    }
    alive_vertex_[v] = 0;
    history_.push_back(std::move(c));
    return true;
}

void Coarsening::put_back(const Collapse& c, std::vector<Vec>& sphere) {
    for (int32_t h : c.moved) corner_[h] = c.vertex;
    for (int32_t f : c.gone) {
        alive_face_[f] = 1;
        for (int k = 0; k < 3; ++k) {
            const int32_t w = corner_[3 * int64_t(f) + k];
            if (w != c.vertex && w != c.onto) star_[w].push_back(f);
        }
    }
    star_[c.onto] = c.star_onto;
    alive_vertex_[c.vertex] = 1;
    ++left_;
    place(c, sphere);
}

// Puts the vertex at the centre of the kernel of its ring, from where all of the ring is seen. In
// the plane that touches the sphere at `onto`, in central projection, arcs are straight and the
// kernel is what the sides of the ring leave of a square.
void Coarsening::place(const Collapse& c, std::vector<Vec>& sphere) const {
    constexpr double kHalfSide = 2;
    using Point = std::array<double, 2>;
    const Vec o = sphere[c.onto];
    const Vec axis = std::abs(o[0]) < 0.6 ? Vec{1, 0, 0} : Vec{0, 1, 0};
    const Vec u = unit(cross(o, axis)), t = cross(o, u);
    std::vector<Point> kernel = {{-kHalfSide, -kHalfSide},
                                 {kHalfSide, -kHalfSide},
                                 {kHalfSide, kHalfSide},
                                 {-kHalfSide, kHalfSide}};
    std::vector<Point> rest;
    for (int32_t f : star_[c.vertex]) {
        const int32_t* w = &corner_[3 * int64_t(f)];
        const int k = w[0] == c.vertex ? 0 : w[1] == c.vertex ? 1 : 2;
        const int32_t from = w[(k + 1) % 3], to = w[(k + 2) % 3];
        const Vec side = cross(sphere[from], sphere[to] - sphere[from]);
        const double here = from == c.onto || to == c.onto ? 0 : dot(side, o);
        const double along = dot(side, u), across = dot(side, t);
        const auto inside = [&](const Point& p) { return here + p[0] * along + p[1] * across; };
        rest.clear();
        for (size_t i = 0; i < kernel.size(); ++i) {
            const Point &p = kernel[i], &q = kernel[(i + 1) % kernel.size()];
            const double at_p = inside(p), at_q = inside(q);
            if (at_p >= 0) rest.push_back(p);
            if ((at_p < 0) != (at_q < 0)) {
                const double part = at_p / (at_p - at_q);
                rest.push_back({p[0] + part * (q[0] - p[0]), p[1] + part * (q[1] - p[1])});
            }
        }
        kernel.swap(rest);
    }
    Point centre = {0, 0};
    for (const Point& p : kernel) {
        centre[0] += p[0] / double(kernel.size());
        centre[1] += p[1] / double(kernel.size());
    }
    sphere[c.vertex] = unit(o + centre[0] * u + centre[1] * t);
}

void Coarsening::refine(std::vector<Vec>& sphere) {
    const size_t start = round_start_.back();
    round_start_.pop_back();
    while (history_.size() > start) {
        put_back(history_.back(), sphere);
        history_.pop_back();
    }
}

std::vector<int32_t> Coarsening::vertices() const {
    std::vector<int32_t> left;
    for (size_t v = 0; v < star_.size(); ++v) {
        if (alive_vertex_[v]) left.push_back(int32_t(v));
    }
    return left;
}

std::vector<int32_t> Coarsening::faces() const {
    std::vector<int32_t> left;
    for (size_t f = 0; f < alive_face_.size(); ++f) {
        if (alive_face_[f]) left.insert(left.end(), &corner_[3 * f], &corner_[3 * f] + 3);
    }
    return left;
}

}  // namespace henkei
