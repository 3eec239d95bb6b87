// The adaptation of a self-organizing deformable model: a mesh drawn onto the control points of a
// surface.
// S. Matsui, K. Morooka, H. Nagahashi, "3-D morphing by direct mapping between mesh models using
// Self-organizing Deformable Model", algorithm 1, steps 3 to 7 (eq. 6 to 10): a control point is
// drawn, its winner among the vertices is found, and the winner and its neighbours move towards it.
// Positions are kept in a grid of cells that follows them, so that the nearest vertex is found
// among few.
#include "kernels.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace henkei {
namespace {

// SplitMix64 (G. Steele, D. Lea, C. Flood 2014): the same numbers on every machine.
struct Random {
    uint64_t state;
    uint64_t next() {
        uint64_t z = (state += 0x9E3779B97F4A7C15u);
        z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
        z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
        return z ^ (z >> 31);
    }
    int64_t below(int64_t bound) { return int64_t((next() >> 11) * 0x1p-53 * double(bound)); }
};

// Vertices by cells of a regular grid over a box; those outside it belong to the nearest cell.
class MovingGrid {
  public:
    MovingGrid(const double* x, int64_t count, const double* low, const double* high, double cell)
        : x_(x), next_(count), previous_(count), cell_of_(count) {
        for (int k = 0; k < 3; ++k) {
            low_[k] = low[k];
            size_[k] = std::max<int64_t>(1, int64_t((high[k] - low[k]) / cell) + 1);
        }
        cell_ = cell;
        head_.assign(size_t(size_[0] * size_[1] * size_[2]), -1);
        for (int64_t v = 0; v < count; ++v) insert(int32_t(v), cell_at(x + 3 * v));
    }

    void moved(int32_t v) {
        const int64_t cell = cell_at(x_ + 3 * v);
        if (cell == cell_of_[v]) return;
        const int32_t before = previous_[v], after = next_[v];
        (before >= 0 ? next_[before] : head_[cell_of_[v]]) = after;
        if (after >= 0) previous_[after] = before;
        insert(v, cell);
    }

    // The vertex nearest to p; of several, the one with the lowest number.
    int32_t nearest(const double* p) const {
        int64_t centre[3];
        double inside = 0;  // how far p is outside of the box
        for (int k = 0; k < 3; ++k) {
            centre[k] = index(p[k], k);
            const double high = low_[k] + cell_ * double(size_[k]);
            const double out = std::max({low_[k] - p[k], p[k] - high, 0.0});
            inside += out * out;
        }
        const double outside = std::sqrt(inside);
        int32_t best = -1;
        double least = std::numeric_limits<double>::infinity();
        const int64_t most = std::max({size_[0], size_[1], size_[2]});
        for (int64_t ring = 0; ring <= most; ++ring) {
            // Cells of this ring are at least ring - 1 cells away from p's own.
            const double away = double(ring - 1) * cell_ - outside;
            if (best >= 0 && away > 0 && away * away > least) break;
            visit_ring(centre, ring, [&](int64_t cell) {
                for (int32_t v = head_[cell]; v >= 0; v = next_[v]) {
                    const double d = squared(x_ + 3 * v, p);
                    if (d < least || (d == least && v < best)) least = d, best = v;
                }
            });
        }
        return best;
    }

    static double squared(const double* a, const double* b) {
        const double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
        return x * x + y * y + z * z;
    }

  private:
    int64_t index(double value, int k) const {
        const double place = std::floor((value - low_[k]) / cell_);
        return int64_t(std::min(std::max(place, 0.0), double(size_[k] - 1)));
    }
    int64_t cell_at(const double* p) const {
        return (index(p[2], 2) * size_[1] + index(p[1], 1)) * size_[0] + index(p[0], 0);
    }
    void insert(int32_t v, int64_t cell) {
        previous_[v] = -1;
        next_[v] = head_[cell];
        if (next_[v] >= 0) previous_[next_[v]] = v;
        head_[cell] = v;
        cell_of_[v] = cell;
    }
    template <class Visit>
    void visit_ring(const int64_t* centre, int64_t ring, Visit visit) const {
        const auto first = [&](int k) { return std::max<int64_t>(centre[k] - ring, 0); };
        const auto last = [&](int k) { return std::min(centre[k] + ring, size_[k] - 1); };
        for (int64_t z = first(2); z <= last(2); ++z) {
            for (int64_t y = first(1); y <= last(1); ++y) {
                const int64_t row = (z * size_[1] + y) * size_[0];
                if (std::abs(z - centre[2]) == ring || std::abs(y - centre[1]) == ring) {
                    for (int64_t x = first(0); x <= last(0); ++x) visit(row + x);
                    continue;
                }
                if (centre[0] - ring >= 0) visit(row + centre[0] - ring);
                if (ring > 0 && centre[0] + ring < size_[0]) visit(row + centre[0] + ring);
            }
        }
    }

    const double* x_;
    std::vector<int32_t> next_, previous_, head_;
    std::vector<int64_t> cell_of_;
    double low_[3], cell_;
    int64_t size_[3];
};

// The literal winner of eq. 6 and 7: the vertex in front of the control point's plane that is
// nearest to that plane; -1 where all are behind it.
int32_t nearest_to_plane(const double* x, int64_t count, const double* p, const double* normal) {
    int32_t best = -1;
    double least = std::numeric_limits<double>::infinity();
    for (int64_t v = 0; v < count; ++v) {
        const double* q = x + 3 * v;
        const double signed_distance =
            normal[0] * (q[0] - p[0]) + normal[1] * (q[1] - p[1]) + normal[2] * (q[2] - p[2]);
        if (signed_distance > 0 && signed_distance < least) least = signed_distance, best = v;
    }
    return best;
}

}  // namespace

int64_t adapt(double* x, int64_t vertices, const int64_t* ring_start, const int32_t* ring,
              const double* points, const double* normals, const int32_t* winners, int64_t count,
              const AdaptationSchedule& schedule, const double* low, const double* high) {
    const double extent = std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
    const double per_side = std::clamp(std::sqrt(double(vertices) / 6), 1.0, 128.0);
    MovingGrid grid(x, vertices, low, high, std::max(extent, 1e-300) / per_side);
    Random random{uint64_t(schedule.seed)};
    std::vector<int64_t> reached(vertices, -1);
    std::vector<int32_t> queue;
    std::vector<double> pull;
    int64_t without = 0;
    for (int64_t step = 0; step < schedule.steps; ++step) {
        if ((step & 0xFFF) == 0) check_interrupt();
        const double done = double(step) / double(schedule.steps);
        const double rate =
            schedule.rate_start * std::pow(schedule.rate_end / schedule.rate_start, done);
        const double radius =
            schedule.radius_start * std::pow(schedule.radius_end / schedule.radius_start, done);
        const int64_t drawn = random.below(count);
        const double* p = points + 3 * drawn;
        int32_t winner = winners[drawn];
        if (winner < 0) {
            winner = schedule.literal ? nearest_to_plane(x, vertices, p, normals + 3 * drawn)
                                      : grid.nearest(p);
        }
        if (winner < 0) {
            ++without;
            continue;
        }
        const int hops = int(std::ceil(3.1 * radius));
        pull.clear();
        for (int h = 0; h <= hops; ++h) {
            pull.push_back(rate * std::exp(-0.5 * (h / radius) * (h / radius)));
        }
        // Breadth-first over the edges; a vertex moves as it is reached.
        queue.assign(1, winner);
        reached[winner] = step;
        size_t ring_end = 1, at = 0;
        for (int h = 0; h <= hops && at < queue.size(); ++h, ring_end = queue.size()) {
            for (; at < ring_end; ++at) {
                const int32_t v = queue[at];
                for (int k = 0; k < 3; ++k) x[3 * v + k] += pull[h] * (p[k] - x[3 * v + k]);
                grid.moved(v);
                if (h == hops) continue;
                for (int64_t e = ring_start[v]; e < ring_start[v + 1]; ++e) {
                    if (reached[ring[e]] == step) continue;
                    reached[ring[e]] = step;
                    queue.push_back(ring[e]);
                }
            }
        }
    }
    return without;
}

}  // namespace henkei
