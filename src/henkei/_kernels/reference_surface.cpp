// Walks and normals; see reference_surface.hpp. Nearest points of a triangle as in C. Ericson,
// "Real-Time Collision Detection", 2005, section 5.1.
#include "reference_surface.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace henkei {
namespace {

constexpr double kThin = 1e-12;     // squared sine of an angle below which a triangle is thin
constexpr double kSame = 1e-13;     // distances that differ by less are alike (the mesh is 1 long)
constexpr int kMostVisits = 20000;  // faces in one walk

int32_t next(int32_t h) {
    return h % 3 == 2 ? h - 2 : h + 1;
}
int32_t previous(int32_t h) {
    return h % 3 == 0 ? h + 2 : h - 1;
}

Vec weighted(const Vec& w, const Vec& a, const Vec& b, const Vec& c) {
    return w[0] * a + w[1] * b + w[2] * c;
}

double along_segment(const Vec& p, const Vec& a, const Vec& b) {
    const Vec side = b - a;
    const double square = dot(side, side);
    return square > 0 ? std::clamp(dot(p - a, side) / square, 0.0, 1.0) : 0.0;
}

Vec weights_within(const Vec& p, const Vec& a, const Vec& b, const Vec& c) {
    const Vec ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
    const double d1 = dot(ab, ap), d2 = dot(ac, ap);
    if (d1 <= 0 && d2 <= 0) return {1, 0, 0};
    const double d3 = dot(ab, bp), d4 = dot(ac, bp);
    if (d3 >= 0 && d4 <= d3) return {0, 1, 0};
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) {
        const double v = d1 / (d1 - d3);
        return {1 - v, v, 0};
    }
    const double d5 = dot(ab, cp), d6 = dot(ac, cp);
    if (d6 >= 0 && d5 <= d6) return {0, 0, 1};
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) {
        const double w = d2 / (d2 - d6);
        return {1 - w, 0, w};
    }
    const double va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
        const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return {0, 1 - w, w};
    }
    const Vec inside = {std::max(va, 0.0), std::max(vb, 0.0), std::max(vc, 0.0)};
    return (1 / (inside[0] + inside[1] + inside[2])) * inside;
}

}  // namespace

double distance_to_segment(const Vec& p, const Vec& a, const Vec& b) {
    return henkei::length(p - a - along_segment(p, a, b) * (b - a));
}

TrianglePoint nearest_on_triangle(const Vec& p, const Vec& a, const Vec& b, const Vec& c) {
    const Vec ab = b - a, ac = c - a, normal = cross(ab, ac);
    const double size = std::max(dot(ab, ab), dot(ac, ac));
    if (dot(normal, normal) > kThin * size * size) {
        const Vec w = weights_within(p, a, b, c), q = weighted(w, a, b, c);
        return {w, q, length(p - q), false};
    }
    TrianglePoint best{{1, 0, 0}, a, length(p - a), true};
    const Vec* corner[3] = {&a, &b, &c};
    for (int k = 0; k < 3; ++k) {
        const int l = (k + 1) % 3;
        const double s = along_segment(p, *corner[k], *corner[l]);
        Vec w{};
        w[k] = 1 - s;
        w[l] = s;
        const Vec q = weighted(w, a, b, c);
        const double distance = length(p - q);
        if (distance < best.distance) best = {w, q, distance, true};
    }
    return best;
}

ReferenceSurface::ReferenceSurface(const RemeshingInput& in)
    : x_(in.x, in.x + in.vertices),
      faces_(in.faces, in.faces + 3 * in.face_count),
      twins_(in.twins, in.twins + 3 * in.face_count),
      feature_(in.feature, in.feature + 3 * in.face_count),
      length_(in.length, in.length + in.vertices),
      normal_of_face_(in.face_count),
      normal_at_(3 * in.face_count, -1),
      visited_(in.face_count, 0) {
    std::vector<Vec> vectors(in.face_count);
    for (int64_t f = 0; f < in.face_count; ++f) {
        const Vec& a = x_[faces_[3 * f]];
        vectors[f] = cross(x_[faces_[3 * f + 1]] - a, x_[faces_[3 * f + 2]] - a);
        normal_of_face_[f] = unit(vectors[f]);
    }
    for (int32_t corner = 0; corner < int32_t(faces_.size()); ++corner) {
        if (normal_at_[corner] >= 0) continue;
        int32_t h = corner;  // clockwise to the feature or boundary, or once round
        while (!feature_[h] && twins_[h] >= 0) {
            h = next(twins_[h]);
            if (h == corner) break;
        }
        const int32_t first = h;
        Vec sum{};
        do {
            normal_at_[h] = int32_t(normals_.size());
            sum = sum + vectors[h / 3];
            const int32_t last = previous(h);
            h = feature_[last] ? -1 : twins_[last];
        } while (h >= 0 && h != first);
        normals_.push_back(unit(sum));
    }
}

void ReferenceSurface::visit(int32_t face, const Vec& p, SurfacePlace& best) {
    visited_[face] = search_;
    const int32_t* c = &faces_[3 * size_t(face)];
    const TrianglePoint found = nearest_on_triangle(p, x_[c[0]], x_[c[1]], x_[c[2]]);
    if (found.distance < best.distance) best = {face, found.weights, found.point, found.distance};
    if (found.distance > best.distance + kSame) return;
    for (int k = 0; k < 3; ++k) {
        if (!found.thin && found.weights[(k + 2) % 3] > 0) continue;
        const int32_t h = 3 * face + k;
        if (!feature_[h] && twins_[h] >= 0) doors_.push_back({twins_[h], found.distance});
    }
}

SurfacePlace ReferenceSurface::nearest(int32_t start, const Vec& p) {
    if (++search_ == 0) {
        std::fill(visited_.begin(), visited_.end(), 0);
        search_ = 1;
    }
    SurfacePlace best;
    best.distance = std::numeric_limits<double>::infinity();
    doors_.clear();
    visit(start, p, best);
    for (int visits = 0; !doors_.empty() && visits < kMostVisits;) {
        const Door door = doors_.back();
        doors_.pop_back();
        const int32_t face = door.half_edge / 3;
        if (door.distance > best.distance + kSame || visited_[face] == search_) continue;
        visit(face, p, best);
        ++visits;
    }
    return best;
}

Vec ReferenceSurface::normal(int32_t f, const Vec& weights) const {
    const int32_t* at = &normal_at_[3 * size_t(f)];
    return unit(weighted(weights, normals_[at[0]], normals_[at[1]], normals_[at[2]]));
}

Vec ReferenceSurface::nearer_normal(int32_t f, const Vec& weights, const Vec& direction) const {
    const Vec smooth = normal(f, weights), &flat = normal_of_face_[f];
    return dot(smooth, direction) >= dot(flat, direction) ? smooth : flat;
}

double ReferenceSurface::length(int32_t f, const Vec& weights) const {
    const int32_t* c = &faces_[3 * size_t(f)];
    return weights[0] * length_[c[0]] + weights[1] * length_[c[1]] + weights[2] * length_[c[2]];
}

SurfacePlace ReferenceSurface::at_corner(int32_t h) const {
    Vec weights{};
    weights[h % 3] = 1;
    return {h / 3, weights, x_[faces_[h]], 0};
}

}  // namespace henkei
