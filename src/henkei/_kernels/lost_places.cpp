// Lists in a common pool; see lost_places.hpp.
#include "lost_places.hpp"

#include <limits>
#include <utility>

#include "reference_surface.hpp"

namespace henkei {
namespace {

constexpr int kMost = 3;  // places of a face

std::pair<double, int32_t> nearest(const Vec& p, const std::vector<FaceShape>& faces) {
    std::pair<double, int32_t> best{std::numeric_limits<double>::infinity(), -1};
    for (const FaceShape& f : faces) {
        const double distance = nearest_on_triangle(p, f.x[0], f.x[1], f.x[2]).distance;
        if (distance < best.first) best = {distance, f.face};
    }
    return best;
}

}  // namespace

bool are_near(const std::vector<Vec>& places, const std::vector<FaceShape>& faces, double most) {
    for (const Vec& p : places) {
        if (nearest(p, faces).first > most) return false;
    }
    return true;
}

void LostPlaces::gather(int32_t face, std::vector<Vec>& places) const {
    for (int32_t k = first_[face]; k >= 0; k = pool_[k].next) places.push_back(pool_[k].point);
}

void LostPlaces::forget(int32_t face) {
    for (int32_t k = first_[face]; k >= 0;) {
        const int32_t next = std::exchange(pool_[k].next, free_);
        free_ = std::exchange(k, next);
    }
    first_[face] = -1;
}

void LostPlaces::assign(const std::vector<Vec>& places, const std::vector<FaceShape>& faces,
                        double least) {
    if (faces.empty()) return;
    for (const Vec& p : places) {
        const auto [distance, face] = nearest(p, faces);
        if (distance > least) add(face, p, distance);
    }
}

void LostPlaces::add(int32_t face, const Vec& point, double distance) {
    int count = 0;
    int32_t nearest = -1;
    for (int32_t k = first_[face]; k >= 0; k = pool_[k].next, ++count) {
        if (nearest < 0 || pool_[k].distance < pool_[nearest].distance) nearest = k;
    }
    if (count == kMost) {
        if (pool_[nearest].distance < distance) {
            pool_[nearest].point = point;
            pool_[nearest].distance = distance;
        }
        return;
    }
    if (free_ < 0) {
        free_ = int32_t(pool_.size());
        pool_.push_back({{}, 0, -1});
    }
    const int32_t at = std::exchange(free_, pool_[free_].next);
    pool_[at] = {point, distance, std::exchange(first_[face], at)};
}

}  // namespace henkei
