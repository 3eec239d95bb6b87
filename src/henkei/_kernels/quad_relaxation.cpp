// The vertices of a quad mesh move along the surface that it lies on until its quads are as square
// as its connectivity allows.
// First all at once: every quad asks for the square that fits it best, every vertex goes to the
// mean of what its quads ask for (S. Bouaziz et al., "Shape-Up: Shaping Discrete Geometry with
// Projections", 2012), with Nesterov's momentum, which is dropped where it overshoots.
// Then vertex by vertex: Newton steps in the tangent plane on the sum over corners of
// (|a|^2 + |b|^2) / 2 det(a, b), convex as long as no corner is inverted, with det regularised so
// that inverted corners turn back (V. Garanzha et al., "Foldover-free maps in 50 lines of code",
// 2021). A step is taken only if it lowers the sum, measured in space.
#include "quad_relaxation.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "kernels.hpp"

namespace henkei {
namespace {

constexpr double kRegular = 0.05;    // of a corner's area, added where it is inverted
constexpr double kTrusted = 0.2;     // least cosine between a quad's own normal and the surface's
constexpr double kLeastSide = 0.25;  // of the wished length, of a square that is asked for

double positive(double ratio) {
    return (ratio + std::sqrt(ratio * ratio + kRegular * kRegular)) / 2;
}

Vec scaled_to(const Vec& v, double most) {
    const double size = length(v);
    return size > most ? (most / size) * v : v;
}

// Two unit vectors at right angles to a normal and to each other.
std::pair<Vec, Vec> tangents(const Vec& normal) {
    const int axis = std::abs(normal[0]) < 0.6 ? 0 : 1;
    Vec along{};
    along[axis] = 1;
    const Vec first = unit(cross(normal, along));
    return {first, cross(normal, first)};
}

}  // namespace

QuadRelaxation::QuadRelaxation(SurfacePlaces surface, ClosestPoints closest, QuadLines lines,
                               std::vector<int32_t> quads, const int32_t* face,
                               const double* weights, const double* points, int64_t vertex_count,
                               std::vector<uint8_t> held, const int32_t* line, const double* arc,
                               const int32_t* beside, const double* limits,
                               std::vector<double> size, const int32_t* centre)
    : surface_(std::move(surface)),
      closest_(std::move(closest)),
      lines_(std::move(lines)),
      quads_(std::move(quads)),
      ring_start_(vertex_count + 1, 0),
      ring_(quads_.size()),
      held_(std::move(held)),
      size_(std::move(size)),
      up_(quads_.size() / 4) {
    for (int64_t v = 0; v < vertex_count; ++v) {
        const Vec weight{weights[3 * v], weights[3 * v + 1], weights[3 * v + 2]};
        const Vec point{points[3 * v], points[3 * v + 1], points[3 * v + 2]};
        spot_.push_back({{face[v], weight, point}, arc[v]});
        bound_.push_back(
            {line[v], beside[2 * v], beside[2 * v + 1], limits[2 * v], limits[2 * v + 1]});
    }
    for (const int32_t v : quads_) ++ring_start_[v + 1];
    for (int64_t v = 0; v < vertex_count; ++v) ring_start_[v + 1] += ring_start_[v];
    std::vector<int64_t> next(ring_start_.begin(), ring_start_.end() - 1);
    for (size_t c = 0; c < quads_.size(); ++c) ring_[next[quads_[c]]++] = int32_t(c);
    for (int64_t q = 0; q < quad_count(); ++q) {
        centre_.push_back(surface_.at(centre[q], {1.0 / 3, 1.0 / 3, 1.0 / 3}));
        const int32_t* c = &quads_[4 * q];
        const double size = (size_[c[0]] + size_[c[1]] + size_[c[2]] + size_[c[3]]) / 4;
        wished_.push_back(size * size);
    }
    find_centres();
}

void QuadRelaxation::find_centre(int64_t q) {
    const Vec middle = 0.25 * (corner(q, 0) + corner(q, 1) + corner(q, 2) + corner(q, 3));
    centre_[q] = surface_.moved(centre_[q], middle);
    up_[q] = surface_.normal(centre_[q]);
}

void QuadRelaxation::find_centres() {
    for (int64_t q = 0; q < quad_count(); ++q) find_centre(q);
}

// How far a vertex may go along its line before it meets its neighbour.
double QuadRelaxation::room(int32_t v, bool forwards) const {
    const Bound& bound = bound_[v];
    const int32_t neighbour = forwards ? bound.after : bound.before;
    const double limit =
        neighbour >= 0 ? spot_[neighbour].arc : (forwards ? bound.high : bound.low);
    double gap = forwards ? limit - spot_[v].arc : spot_[v].arc - limit;
    if (lines_.closed[bound.line]) {
        const double whole = lines_.arc[lines_.start[bound.line + 1] - 1];
        gap -= whole * std::floor(gap / whole);
        if (gap == 0) gap = whole;
    }
    return std::max(gap, 0.0);
}

// The point of a vertex's line nearest to `to`, from arc length low to high.
QuadRelaxation::Spot QuadRelaxation::on_line(int32_t v, const Vec& to, double low,
                                             double high) const {
    const int32_t line = bound_[v].line;
    const auto first = lines_.arc.begin() + lines_.start[line];
    const int64_t count = lines_.start[line + 1] - lines_.start[line];
    const double whole = first[count - 1];
    double shift = lines_.closed[line] ? whole * std::floor(low / whole) : 0.0;
    int64_t i = std::upper_bound(first, first + count, low - shift) - first - 1;
    i = std::clamp(i, int64_t(0), count - 2);
    Spot best{};
    double least = INFINITY;
    for (; first[i] + shift <= high;) {
        const int64_t at = lines_.start[line] + i;
        const Vec &start = lines_.point[at], &end = lines_.point[at + 1];
        const Vec side = end - start;
        const double size = first[i + 1] - first[i];
        double t = size > 0 ? dot(to - start, side) / (size * size) : 0.0;
        t = std::clamp(t, 0.0, 1.0);
        const double arc = std::clamp(first[i] + shift + t * size, low, high);
        t = size > 0 ? std::clamp((arc - first[i] - shift) / size, 0.0, 1.0) : 0.0;
        const Vec point = start + t * side, off = to - point;
        if (dot(off, off) < least) {
            least = dot(off, off);
            const int32_t mark = lines_.half_edge[at], h = mark >= 0 ? mark : -1 - mark;
            best = {{h / 3, {}, point}, arc};
            best.place.weights[h % 3] = mark >= 0 ? 1 - t : t;
            best.place.weights[(h % 3 + 1) % 3] = mark >= 0 ? t : 1 - t;
        }
        if (++i < count - 1) continue;
        if (!lines_.closed[line]) break;
        i = 0;
        shift += whole;
    }
    if (least == INFINITY) return spot_[v];
    if (lines_.closed[line]) best.arc -= whole * std::floor(best.arc / whole);
    return best;
}

// Two directions in which a vertex may move: in the tangent plane, or along its line, twice.
std::pair<Vec, Vec> QuadRelaxation::directions(int32_t v) const {
    const int32_t line = bound_[v].line;
    if (line < 0) return tangents(surface_.normal(spot_[v].place));
    const auto first = lines_.arc.begin() + lines_.start[line];
    const auto last = lines_.arc.begin() + lines_.start[line + 1] - 1;
    const int64_t at = std::upper_bound(first, last, spot_[v].arc) - lines_.arc.begin();
    const int64_t start = std::max(at - 1, lines_.start[line]);
    const Vec along = unit(lines_.point[start + 1] - lines_.point[start]);
    return {along, along};
}

// Where a vertex comes to when it wants to go to a point: of the way along a line to its
// neighbours it takes no more than `share`.
QuadRelaxation::Spot QuadRelaxation::moved(int32_t v, const Vec& to, double share) {
    if (bound_[v].line < 0) return {surface_.moved(spot_[v].place, to), 0};
    const double arc = spot_[v].arc;
    return on_line(v, to, arc - share * room(v, false), arc + share * room(v, true));
}

void QuadRelaxation::fit(int iterations, double evenness) {
    const int64_t count = vertex_count();
    std::vector<Vec> now(count), sum(count);
    std::vector<double> weight(count);
    for (int64_t v = 0; v < count; ++v) now[v] = spot_[v].place.point;
    double last = INFINITY;
    int momentum = 0;
    for (int iteration = 0; iteration < iterations; ++iteration) {
        check_interrupt();
        if (iteration % 4 == 0) find_centres();
        std::fill(sum.begin(), sum.end(), Vec{});
        std::fill(weight.begin(), weight.end(), 0.0);
        double misfit = 0;
        for (int64_t q = 0; q < quad_count(); ++q) {
            const int32_t* c = &quads_[4 * q];
            const Vec diagonal = now[c[2]] - now[c[0]], other = now[c[3]] - now[c[1]];
            Vec normal = unit(cross(diagonal, other));
            if (dot(normal, up_[q]) < kTrusted) normal = up_[q];
            Vec half = 0.25 * (diagonal - cross(normal, other));
            const double wished =
                0.25 * (size_[c[0]] + size_[c[1]] + size_[c[2]] + size_[c[3]]) / std::sqrt(2.0);
            double size = length(half);
            if (!(size > kLeastSide * wished)) {
                half = size > 0 ? (kLeastSide * wished / size) * half : half;
                size = kLeastSide * wished;
            }
            half = std::pow(wished / size, evenness) * half;
            const Vec across = cross(normal, half);
            const Vec middle = 0.25 * (now[c[0]] + now[c[1]] + now[c[2]] + now[c[3]]);
            const Vec wish[4] = {middle - half, middle - across, middle + half, middle + across};
            const double w = 1 / (size * size);
            for (int k = 0; k < 4; ++k) {
                const Vec off = wish[k] - now[c[k]];
                misfit += w * dot(off, off);
                sum[c[k]] = sum[c[k]] + w * wish[k];
                weight[c[k]] += w;
            }
        }
        momentum = misfit <= last ? momentum + 1 : 0;
        last = misfit;
        const double carried = std::max(0.0, (momentum - 1.0) / (momentum + 2.0));
        for (int64_t v = 0; v < count; ++v) {
            if (held_[v] || weight[v] == 0) continue;
            const Vec before = spot_[v].place.point;
            const Vec to = (1 / weight[v]) * sum[v];
            const double far = 2 * size_[v];
            spot_[v] = moved(int32_t(v), before + scaled_to(to - before, far), 0.45);
            const Vec& point = spot_[v].place.point;
            now[v] = point + carried * (point - before);
        }
    }
    find_centres();
}

// The least scaled Jacobian of a quad's corners, turned negative if it faces against the surface.
double QuadRelaxation::jacobian(int64_t q) const {
    Vec normal = unit(cross(corner(q, 2) - corner(q, 0), corner(q, 3) - corner(q, 1)));
    if (dot(normal, up_[q]) < 0) normal = -1.0 * normal;
    double least = 1;
    for (int k = 0; k < 4; ++k) {
        const Vec a = corner(q, k + 1) - corner(q, k), b = corner(q, k + 3) - corner(q, k);
        const double size = std::sqrt(dot(a, a) * dot(b, b));
        least = std::min(least, size > 0 ? dot(normal, cross(a, b)) / size : -1.0);
    }
    return least;
}

double QuadRelaxation::distortion(int32_t v, double power, double stretch) const {
    double total = 0;
    for (int64_t i = ring_start_[v]; i < ring_start_[v + 1]; ++i) {
        const int64_t q = ring_[i] / 4;
        Vec normal = unit(cross(corner(q, 2) - corner(q, 0), corner(q, 3) - corner(q, 1)));
        if (dot(normal, up_[q]) < 0) normal = -1.0 * normal;
        const double wished = wished_[q];
        for (int k = 0; k < 4; ++k) {
            const Vec a = corner(q, k + 1) - corner(q, k), b = corner(q, k + 3) - corner(q, k);
            const double aa = dot(a, a), bb = dot(b, b);
            const double pull = std::pow(bb / std::max(aa, 1e-300), stretch / 2);
            const double mean = (pull * aa + bb / pull) / 2;
            if (!(mean > 0)) return INFINITY;
            const double ratio = positive(dot(normal, cross(a, b)) / mean),
                         size = ratio * mean / wished;
            total += std::pow(1 / ratio + evenness_ * (size + 1 / size), power);
        }
    }
    return total;
}

// Mean length of the edges at a vertex.
double QuadRelaxation::reach(int32_t v) const {
    double total = 0;
    for (int64_t i = ring_start_[v]; i < ring_start_[v + 1]; ++i) {
        total += length(corner(ring_[i] / 4, ring_[i] % 4 + 1) - spot_[v].place.point);
    }
    return total / double(ring_start_[v + 1] - ring_start_[v]);
}

bool QuadRelaxation::try_step(int32_t v, const Vec& step, double power, double stretch,
                              double before) {
    const Spot old = spot_[v];
    double share = 1;
    for (int attempt = 0; attempt < 5; ++attempt, share *= 0.4) {
        spot_[v] = moved(v, old.place.point + share * step, 1 - kLeastRoom);
        if (distortion(v, power, stretch) < before) return true;
        spot_[v] = old;
    }
    return false;
}

void QuadRelaxation::newton(int32_t v, double power, double stretch) {
    const auto [s, t] = directions(v);
    double gs = 0, gt = 0, hss = 0, hst = 0, htt = 0;
    for (int64_t i = ring_start_[v]; i < ring_start_[v + 1]; ++i) {
        const int64_t q = ring_[i] / 4;
        Vec normal = unit(cross(corner(q, 2) - corner(q, 0), corner(q, 3) - corner(q, 1)));
        if (dot(normal, up_[q]) < kTrusted) normal = up_[q];
        const int here = ring_[i] % 4;
        const double wished = wished_[q];
        for (const int k : {here, here + 1, here + 3}) {
            const Vec c = corner(q, k), a = corner(q, k + 1) - c, b = corner(q, k + 3) - c;
            const double aa = dot(a, a), bb = dot(b, b);
            if (!(aa > 0 && bb > 0)) continue;
            const double pull = std::pow(bb / aa, stretch / 2);
            const double mean = (pull * aa + bb / pull) / 2;
            // Gradients with regard to x of the mean square and of the corner's area.
            Vec up_mean, up_area;
            double curve;
            if (k == here) {
                up_mean = -pull * a - (1 / pull) * b;
                up_area = cross(normal, b - a);
                curve = pull + 1 / pull;
            } else if (k == here + 1) {  // x is the last corner before c
                up_mean = (1 / pull) * b;
                up_area = cross(normal, a);
                curve = 1 / pull;
            } else {
                up_mean = pull * a;
                up_area = -1.0 * cross(normal, b);
                curve = pull;
            }
            const double area = dot(normal, cross(a, b)), ratio = area / mean;
            const double root = std::sqrt(ratio * ratio + kRegular * kRegular);
            const double size = mean * (ratio + root) / 2;  // the area, made positive
            const double slope = (1 + ratio / root) / 2;
            const double shape = mean / size, part = size / wished;
            const double value = shape + evenness_ * (part + 1 / part);
            const double ms = dot(up_mean, s), mt = dot(up_mean, t);
            const double as = slope * dot(up_area, s), at = slope * dot(up_area, t);
            const double rise = evenness_ * (1 / wished - wished / (size * size)) - shape / size;
            const double fs = ms / size + rise * as, ft = mt / size + rise * at;
            const double w = power * std::pow(value, power - 1), bend = w * (power - 1) / value;
            gs += w * fs, gt += w * ft;
            const double over = 1 / (size * size);
            const double swell = 2 * (shape + evenness_ * wished / size) * over;
            hss += w * (curve / size - 2 * ms * as * over + swell * as * as) + bend * fs * fs;
            hst += w * (swell * as * at - (ms * at + mt * as) * over) + bend * fs * ft;
            htt += w * (curve / size - 2 * mt * at * over + swell * at * at) + bend * ft * ft;
        }
    }
    const double least = 1e-6 * (hss + htt);
    hss += least, htt += least;
    const double determinant = hss * htt - hst * hst;
    Vec step;
    if (bound_[v].line >= 0) {
        step = (-gs / (std::abs(hss) + 1e-300)) * s;
    } else if (determinant > 0) {
        step =
            ((hst * gt - htt * gs) / determinant) * s + ((hst * gs - hss * gt) / determinant) * t;
    } else {
        step = (-1.0 / (std::abs(hss) + std::abs(htt) + 1e-300)) * (gs * s + gt * t);
    }
    const double size = reach(v);
    if (length(step) < 1e-4 * size) return;
    try_step(v, scaled_to(step, 0.6 * size), power, stretch, distortion(v, power, stretch));
}

void QuadRelaxation::improve(int sweeps, double power, double stretch, double evenness) {
    evenness_ = evenness;
    for (int sweep = 0; sweep < sweeps; ++sweep) {
        check_interrupt();
        for (int32_t v = 0; v < vertex_count(); ++v) {
            const int32_t u = sweep % 2 ? int32_t(vertex_count()) - 1 - v : v;
            if (!held_[u] && ring_start_[u] < ring_start_[u + 1]) newton(u, power, stretch);
        }
        find_centres();
    }
}

void QuadRelaxation::pin(const int32_t* vertices, const int32_t* face, const double* weights,
                         int64_t count) {
    for (int64_t i = 0; i < count; ++i) {
        const Vec weight{weights[3 * i], weights[3 * i + 1], weights[3 * i + 2]};
        spot_[vertices[i]] = {surface_.at(face[i], weight), 0};
        held_[vertices[i]] = 1;
    }
    find_centres();
}

void QuadRelaxation::save(int slot) {
    if (saved_.size() <= size_t(slot)) saved_.resize(slot + 1);
    saved_[slot] = {spot_, held_};
}

void QuadRelaxation::restore(int slot) {
    if (saved_.size() <= size_t(slot) || saved_[slot].held.empty()) return;
    spot_ = saved_[slot].spot;
    held_ = saved_[slot].held;
    find_centres();
}

void QuadRelaxation::quality(double* standing) {
    find_centres();
    for (int64_t q = 0; q < quad_count(); ++q) standing[q] = this->standing(q);
}

void QuadRelaxation::result(double* points, int32_t* face, double* weights) const {
    for (int64_t v = 0; v < vertex_count(); ++v) {
        const WalkedPlace& place = spot_[v].place;
        face[v] = place.face;
        std::copy(place.point.begin(), place.point.end(), points + 3 * v);
        std::copy(place.weights.begin(), place.weights.end(), weights + 3 * v);
    }
}

}  // namespace henkei
