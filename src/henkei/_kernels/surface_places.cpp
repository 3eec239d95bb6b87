// Nearest points on one sheet of a triangle mesh, by a flood from the face where a point was.
#include "surface_places.hpp"

#include <algorithm>

namespace henkei {
namespace {

constexpr size_t kMostFaces = 4096;    // that one search looks at
constexpr double kLeastNormal = 1e-3;  // length of a sum of unit vectors that has a direction

double clamped(double value) {
    return std::clamp(value, 0.0, 1.0);
}

}  // namespace

SurfacePlaces::SurfacePlaces(const double* vertices, int64_t vertex_count, const int32_t* faces,
                             const int32_t* twins, int64_t face_count)
    : point_(vertex_count),
      normal_(3 * face_count, Vec{}),
      face_normal_(face_count),
      faces_(faces, faces + 3 * face_count),
      twins_(twins, twins + 3 * face_count),
      seen_(face_count, 0) {
    for (int64_t v = 0; v < vertex_count; ++v) {
        point_[v] = {vertices[3 * v], vertices[3 * v + 1], vertices[3 * v + 2]};
    }
    for (int64_t f = 0; f < face_count; ++f) {
        const Vec& a = point_[faces[3 * f]];
        face_normal_[f] = unit(cross(point_[faces[3 * f + 1]] - a, point_[faces[3 * f + 2]] - a));
    }
    set_normals();
}

// At each corner of a face the mean over the faces around, as far as twins lead.
void SurfacePlaces::set_normals() {
    std::vector<uint8_t> done(faces_.size(), 0);
    std::vector<int32_t> sector;
    for (size_t c = 0; c < faces_.size(); ++c) {
        if (done[c]) continue;
        sector.assign(1, int32_t(c));
        done[c] = 1;
        for (size_t i = 0; i < sector.size(); ++i) {
            const int32_t at = sector[i], back = at % 3 ? at - 1 : at + 2;
            const int32_t ahead = twins_[at], behind = twins_[back];
            const int32_t next[2] = {ahead < 0 ? at : (ahead % 3 == 2 ? ahead - 2 : ahead + 1),
                                     behind < 0 ? at : behind};
            for (const int32_t other : next) {
                if (done[other]) continue;
                done[other] = 1;
                sector.push_back(other);
            }
        }
        Vec sum{};
        for (const int32_t at : sector) {
            const int32_t* corner = &faces_[at / 3 * 3];
            const Vec& a = point_[corner[0]];
            sum = sum + cross(point_[corner[1]] - a, point_[corner[2]] - a);
        }
        for (const int32_t at : sector) normal_[at] = unit(sum);
    }
}

WalkedPlace SurfacePlaces::at(int32_t face, const Vec& weights) const {
    const int32_t* corner = &faces_[3 * size_t(face)];
    return {face, weights,
            weights[0] * point_[corner[0]] + weights[1] * point_[corner[1]] +
                weights[2] * point_[corner[2]]};
}

Vec SurfacePlaces::normal(const WalkedPlace& place) const {
    const Vec* corner = &normal_[3 * size_t(place.face)];
    const Vec& w = place.weights;
    const Vec mean = w[0] * corner[0] + w[1] * corner[1] + w[2] * corner[2];
    const double size = length(mean);
    return size > kLeastNormal ? (1 / size) * mean : face_normal_[place.face];
}

double SurfacePlaces::nearest(int32_t face, const Vec& to, WalkedPlace& place) const {
    const int32_t* corner = &faces_[3 * size_t(face)];
    const Vec &a = point_[corner[0]], &b = point_[corner[1]], &c = point_[corner[2]];
    const Vec ab = b - a, ac = c - a, ap = to - a, normal = cross(ab, ac);
    const double area = dot(normal, normal);
    const double v = dot(cross(ap, ac), normal) / area, w = dot(cross(ab, ap), normal) / area;
    if (v >= 0 && w >= 0 && v + w <= 1) {  // false where there is no area
        place = {face, {1 - v - w, v, w}, a + v * ab + w * ac};
        const Vec off = to - place.point;
        return dot(off, off);
    }
    double least = INFINITY;
    for (int k = 0; k < 3; ++k) {
        const Vec &start = point_[corner[k]], &end = point_[corner[(k + 1) % 3]];
        const Vec side = end - start;
        const double size = dot(side, side);
        const double s = size > 0 ? clamped(dot(to - start, side) / size) : 0.0;
        const Vec point = start + s * side, off = to - point;
        const double distance = dot(off, off);
        if (distance < least) {
            least = distance;
            place = {face, {}, point};
            place.weights[k] = 1 - s;
            place.weights[(k + 1) % 3] = s;
        }
    }
    return least;
}

WalkedPlace SurfacePlaces::moved(const WalkedPlace& from, const Vec& to) {
    ++round_;
    const Vec step = to - from.point;
    const double reach = dot(step, step) * (1 + 1e-9);
    WalkedPlace best = from, place;
    double least = nearest(from.face, to, best);
    open_.assign(1, from.face);
    seen_[from.face] = round_;
    for (size_t i = 0; i < open_.size() && open_.size() < kMostFaces; ++i) {
        for (int k = 0; k < 3; ++k) {
            const int32_t twin = twins_[3 * size_t(open_[i]) + k];
            if (twin < 0 || seen_[twin / 3] == round_) continue;
            seen_[twin / 3] = round_;
            const double distance = nearest(twin / 3, to, place);
            if (distance > reach) continue;
            open_.push_back(twin / 3);
            if (distance < least) {
                least = distance;
                best = place;
            }
        }
    }
    return best;
}

}  // namespace henkei
