// Quads that are bad are searched better places for their vertices, one vertex at a time; where
// that does not do, their neighbourhood is shaken and relaxed anew.
#include <algorithm>
#include <cmath>
#include <utility>

#include "kernels.hpp"
#include "quad_relaxation.hpp"

namespace henkei {
namespace {

constexpr double kUpright = 3;     // weighs the cosine between quad and surface against a Jacobian
constexpr double kSharpness = 12;  // how far the worst quad prevails over the others
constexpr double kBad = 1e-3;      // standing up to which a quad is bad
constexpr double kFair = 0.3;      // and from which on it is left alone
constexpr double kLocalEvenness = 0.05;
constexpr double kShake = 0.6;  // largest move, in mean edge lengths
constexpr int kLocalSweeps = 10, kMostTries = 60;

// The next of a row of random numbers, from -1 to 1.
double chance(uint64_t& random) {
    random = random * 6364136223846793005ull + 1442695040888963407ull;
    return double(random >> 11) / 4503599627370496.0 - 1;
}

}  // namespace

// The scaled Jacobian, less where the quad turns away from the face that is nearest to its centre,
// on whatever sheet that is.
double QuadRelaxation::standing(int64_t q) const {
    const Vec middle = 0.25 * (corner(q, 0) + corner(q, 1) + corner(q, 2) + corner(q, 3));
    int32_t face;
    double weights[3], distance;
    closest_.query(middle.data(), 1, &face, weights, &distance);
    const Vec normal = unit(cross(corner(q, 2) - corner(q, 0), corner(q, 3) - corner(q, 1)));
    const double upright = dot(normal, surface_.face_normal(face));
    return std::min(jacobian(q), std::max(kUpright * upright, -1.0));
}

// Dominated by the worst quad around a vertex.
double QuadRelaxation::risk(int32_t v) const {
    double total = 0;
    for (int64_t i = ring_start_[v]; i < ring_start_[v + 1]; ++i) {
        total += std::exp(-kSharpness * standing(ring_[i] / 4));
    }
    return total;
}

// Steps in eight directions, ever smaller, towards less risk.
void QuadRelaxation::search(int32_t v, double angle) {
    double least = risk(v), step = 0.5 * reach(v);
    for (int round = 0; round < 7; ++round, step *= 0.5) {
        const auto [s, t] = directions(v);
        const Spot old = spot_[v];
        Spot best = old;
        const int count = bound_[v].line < 0 ? 8 : 2;
        for (int direction = 0; direction < count; ++direction) {
            const double turned = angle + direction * 2 * M_PI / count;
            const Vec aside = bound_[v].line < 0 ? std::sin(turned) * t : Vec{};
            const double along = bound_[v].line < 0 ? std::cos(turned) : 1.0 - 2 * direction;
            const Vec to = old.place.point + step * (along * s + aside);
            spot_[v] = old;
            const Spot there = moved(v, to, 1 - kLeastRoom);
            spot_[v] = there;
            const double now = risk(v);
            if (now < least) {
                least = now;
                best = there;
            }
        }
        spot_[v] = best;
    }
}

void QuadRelaxation::untangle(int sweeps, double floor, uint64_t seed) {
    uint64_t random = seed * 2 + 1;
    std::vector<std::pair<double, int32_t>> order;
    double last = INFINITY;
    for (int sweep = 0; sweep < sweeps; ++sweep) {
        check_interrupt();
        std::vector<double> near(vertex_count(), 1.0);
        double now = 0;
        for (int64_t q = 0; q < quad_count(); ++q) {
            const double least = standing(q);
            if (least >= floor) continue;
            now += std::exp(-kSharpness * least);
            for (int k = 0; k < 4; ++k) {  // and the vertices next to it
                const int32_t v = quads_[4 * q + k];
                for (int64_t i = ring_start_[v]; i < ring_start_[v + 1]; ++i) {
                    for (int m = 0; m < 4; ++m) {
                        double& value = near[quads_[ring_[i] / 4 * 4 + m]];
                        value = std::min(value, least);
                    }
                }
            }
        }
        if (now > 0.98 * last || now == 0) return;
        last = now;
        order.clear();
        for (int32_t v = 0; v < vertex_count(); ++v) {
            if (near[v] < 1 && !held_[v]) order.emplace_back(near[v], v);
        }
        std::sort(order.begin(), order.end());
        for (const auto& [value, v] : order) {
            search(v, chance(random) * M_PI);
        }
        find_centres();
    }
}

// A quad, and the vertices and quads that are at most `rings` quads away from it.
QuadRelaxation::Region QuadRelaxation::around(int64_t quad, int rings) const {
    Region region{{}, {quad}};
    std::vector<uint8_t> has_vertex(vertex_count(), 0), has_quad(quad_count(), 0);
    has_quad[quad] = 1;
    size_t quads_done = 0;
    for (int ring = 0; ring <= rings; ++ring) {
        const size_t first = region.vertices.size();
        for (; quads_done < region.quads.size(); ++quads_done) {
            for (int k = 0; k < 4; ++k) {
                const int32_t v = quads_[4 * region.quads[quads_done] + k];
                if (!has_vertex[v]) region.vertices.push_back(v);
                has_vertex[v] = 1;
            }
        }
        for (size_t i = first; i < region.vertices.size(); ++i) {
            const int32_t v = region.vertices[i];
            for (int64_t j = ring_start_[v]; j < ring_start_[v + 1]; ++j) {
                const int64_t q = ring_[j] / 4;
                if (!has_quad[q]) region.quads.push_back(q);
                has_quad[q] = 1;
            }
        }
    }
    const auto is_held = [this](int32_t v) { return held_[v] != 0; };
    auto& vertices = region.vertices;
    vertices.erase(std::remove_if(vertices.begin(), vertices.end(), is_held), vertices.end());
    return region;
}

// How many quads of a region are bad, and the least standing.
std::pair<int, double> QuadRelaxation::fault(const Region& region) const {
    std::pair<int, double> fault{0, -1.0};
    for (const int64_t q : region.quads) {
        const double now = standing(q);
        fault.first += now <= kBad;
        fault.second = std::max(fault.second, -now);
    }
    return fault;
}

// Shakes a region and relaxes it; whether that was kept, since it is better then.
bool QuadRelaxation::try_anew(const Region& region, double shake, uint64_t& random) {
    const auto before = fault(region);
    std::vector<Spot> old;
    for (const int32_t v : region.vertices) old.push_back(spot_[v]);
    for (const int32_t v : region.vertices) {
        const auto [s, t] = directions(v);
        const double size = shake * reach(v), along = size * chance(random),
                     aside = size * chance(random);
        spot_[v] = moved(v, spot_[v].place.point + along * s + aside * t, 1 - kLeastRoom);
    }
    for (int sweep = 0; sweep < kLocalSweeps; ++sweep) {
        for (const int64_t q : region.quads) find_centre(q);
        for (const int32_t v : region.vertices) newton(v, 2.0 + sweep / 4, 0.5);
    }
    for (int sweep = 0; sweep < 2; ++sweep) {
        for (const int64_t q : region.quads) find_centre(q);
        for (const int32_t v : region.vertices) {
            double least = 1;
            for (int64_t i = ring_start_[v]; i < ring_start_[v + 1]; ++i) {
                least = std::min(least, standing(ring_[i] / 4));
            }
            if (least < kFair) search(v, chance(random) * M_PI);
        }
    }
    for (const int64_t q : region.quads) find_centre(q);
    if (fault(region) < before) return true;
    for (size_t i = 0; i < old.size(); ++i) spot_[region.vertices[i]] = old[i];
    for (const int64_t q : region.quads) find_centre(q);
    return false;
}

void QuadRelaxation::mend(int tries, uint64_t seed) {
    uint64_t random = seed * 2 + 1;
    evenness_ = kLocalEvenness;
    int left = kMostTries;
    for (int64_t q = 0; q < quad_count(); ++q) {
        for (int attempt = 0; attempt < tries && left > 0 && standing(q) <= kBad; ++attempt) {
            --left;
            check_interrupt();
            try_anew(around(q, 1 + attempt % 3), kShake * (attempt % 5) / 4, random);
        }
    }
}

}  // namespace henkei
