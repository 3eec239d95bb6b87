// A quad mesh whose quads can be taken out; see quad_half_edges.hpp.
#include "quad_half_edges.hpp"

#include <utility>

namespace henkei {
namespace {

constexpr double kMiddle = 0.02;  // part of the squared distance of two vertices by which the
                                  // surface must be nearer to one of them than to their middle
constexpr double kStep = 0.5;     // of smoothing, towards the mean of the neighbours
constexpr double kAcross = 0.5;   // weight of a neighbour across a quad
constexpr double kNear = 0.1;     // distance from the surface in which smoothing may end, in edges

double squared(double value) {
    return value * value;
}

}  // namespace

void Quadric::add_plane(const Vec& normal, const Vec& point) {
    const double offset = -dot(normal, point);
    int k = 0;
    for (int i = 0; i < 3; ++i) {
        for (int j = i; j < 3; ++j) square_[k++] += normal[i] * normal[j];
        linear_[i] += offset * normal[i];
    }
    constant_ += offset * offset;
    ++planes_;
}

Quadric& Quadric::operator+=(const Quadric& other) {
    for (int i = 0; i < 6; ++i) square_[i] += other.square_[i];
    for (int i = 0; i < 3; ++i) linear_[i] += other.linear_[i];
    constant_ += other.constant_;
    planes_ += other.planes_;
    return *this;
}

double Quadric::mean(const Vec& p) const {
    if (planes_ == 0) return 0;
    const double squares =
        square_[0] * p[0] * p[0] + square_[3] * p[1] * p[1] + square_[5] * p[2] * p[2];
    const double mixed =
        square_[1] * p[0] * p[1] + square_[2] * p[0] * p[2] + square_[4] * p[1] * p[2];
    const double linear = linear_[0] * p[0] + linear_[1] * p[1] + linear_[2] * p[2];
    return std::max(squares + 2 * (mixed + linear) + constant_, 0.0) / double(planes_);
}

QuadHalfEdges::QuadHalfEdges(QuadsWithSizes quads) : mesh_(std::move(quads)) {
    const size_t n = mesh_.points.size(), half_edges = mesh_.origin.size();
    count_ = int64_t(half_edges / 4);
    alive_.assign(half_edges / 4, 1);
    out_.assign(n, -1);
    valence_.assign(n, 0);
    border_.assign(n, 0);
    quadric_.resize(n);
    for (int h = 0; h < int(half_edges); ++h) {
        const int v = origin(h), ahead = target(h), back = origin(previous(h));
        out_[v] = h;
        ++valence_[v];
        if (twin(h) < 0) {
            ++valence_[ahead];
            border_[v] = border_[ahead] = 1;
        }
        const Vec normal = unit(cross(point(ahead) - point(v), point(back) - point(v)));
        quadric_[v].add_plane(normal, point(v));
    }
}

void QuadHalfEdges::set(int32_t& value, int32_t to) {
    log_.emplace_back(&value, value);
    value = to;
}

void QuadHalfEdges::undo() {
    for (; !log_.empty(); log_.pop_back()) *log_.back().first = log_.back().second;
    for (; !places_.empty(); places_.pop_back()) {
        const Place& place = places_.back();
        mesh_.points[place.vertex] = place.point;
        mesh_.sizes[place.vertex] = place.size;
        quadric_[place.vertex] = place.quadric;
    }
    count_ = std::count(alive_.begin(), alive_.end(), 1);
}

void QuadHalfEdges::commit() {
    log_.clear();
    places_.clear();
}

Vec QuadHalfEdges::joint_place(int a, int b, const Quadric& both) const {
    if (rank(a) || rank(b)) return point(kept_of(a, b));
    const Vec middle = 0.5 * (point(a) + point(b)), apart = point(a) - point(b);
    const double bias = kMiddle * dot(apart, apart);
    const double at_a = both.mean(point(a)) + bias, at_b = both.mean(point(b)) + bias;
    if (both.mean(middle) <= std::min(at_a, at_b)) return middle;
    return at_a <= at_b ? point(a) : point(b);
}

double QuadHalfEdges::harm(int a, int b) const {
    Quadric both = quadric_[a];
    both += quadric_[b];
    const double mean = 0.5 * (size(a) + size(b));
    return both.mean(joint_place(a, b, both)) / (mean * mean);
}

void QuadHalfEdges::merge(int kept, int gone) {
    around(gone, [&](int h) { set(mesh_.origin[h], kept); });
    places_.push_back({kept, point(kept), size(kept), quadric_[kept]});
    quadric_[kept] += quadric_[gone];
    mesh_.points[kept] = joint_place(kept, gone, quadric_[kept]);
    mesh_.sizes[kept] = 0.5 * (size(kept) + size(gone));
    if (border(gone)) {
        set(mesh_.wished[kept], wished(gone) + (border(kept) ? wished(kept) - 3 : 0));
        set(border_[kept], 1);
    }
    set(out_[gone], -1);
}

// The edges of a quad that goes become one.
void QuadHalfEdges::join(int h, int g) {
    const int a = twin(h), b = twin(g);
    const bool on_line = feature(h) || feature(g);
    for (const auto& [one, other] : {std::pair{a, b}, std::pair{b, a}}) {
        if (one < 0) continue;
        set(mesh_.twin[one], other);
        if (on_line) set(mesh_.feature[one], 1);
    }
}

void QuadHalfEdges::remove(int quad) {
    set(alive_[quad], 0);
    --count_;
}

void QuadHalfEdges::start_at(int v, std::initializer_list<int> half_edges) {
    for (const int h : half_edges) {
        if (h < 0 || !alive_[h / 4]) continue;
        set(out_[v], origin(h) == v ? h : next(h));
        return;
    }
}

bool QuadHalfEdges::collapse_diagonal(int h) {
    const int sides[4] = {h, next(h), opposite(h), previous(h)};
    int corner[4], outer[4];
    for (int i = 0; i < 4; ++i) {
        corner[i] = origin(sides[i]);
        outer[i] = twin(sides[i]);
    }
    if (corner[0] == corner[2] || corner[1] == corner[3]) return false;
    if (rank(corner[0]) && rank(corner[2])) return false;
    for (int i = 0; i < 4; i += 2) {
        if (outer[i] == sides[i + 1] || (outer[i] < 0 && outer[i + 1] < 0)) return false;
    }
    const int kept = kept_of(corner[0], corner[2]);
    merge(kept, kept == corner[0] ? corner[2] : corner[0]);
    remove(h / 4);
    join(sides[0], sides[1]);
    join(sides[2], sides[3]);
    start_at(kept, {outer[0], outer[1], outer[2], outer[3]});
    start_at(corner[1], {outer[0], outer[1]});
    start_at(corner[3], {outer[2], outer[3]});
    return true;
}

bool QuadHalfEdges::collapse_row(const std::vector<int>& entries, bool closed) {
    std::vector<int> rungs = entries;
    if (!closed) rungs.push_back(opposite(entries.back()));
    std::vector<int> outer;
    for (const int h : entries) {
        const int right = twin(next(h)), left = twin(previous(h));
        if (right < 0 && left < 0) return false;
        if (right >= 0) outer.push_back(right);
        if (left >= 0) outer.push_back(left);
    }
    for (const int h : rungs) {
        const int a = origin(h), b = target(h), kept = kept_of(a, b);
        merge(kept, kept == a ? b : a);
    }
    for (const int h : entries) remove(h / 4);
    for (const int h : entries) join(next(h), previous(h));
    for (const int h : outer) {
        start_at(origin(h), {h});
        start_at(target(h), {next(h)});
    }
    return true;
}

bool QuadHalfEdges::check(int v, int least, int most) {
    bool proper = true, open = false;
    neighbours_.clear();
    around(v, [&](int h) {
        const int ahead = target(h), across = origin(opposite(h)), back = origin(previous(h));
        proper &= v != ahead && v != across && v != back;
        proper &= ahead != across && across != back && back != ahead;
        neighbours_.push_back(ahead);
        if (twin(previous(h)) < 0) {
            neighbours_.push_back(back);
            open = true;
        }
    });
    std::sort(neighbours_.begin(), neighbours_.end());
    const auto twice = std::adjacent_find(neighbours_.begin(), neighbours_.end());
    const int count = int(neighbours_.size());
    set(valence_[v], count);
    return proper && open == border(v) && twice == neighbours_.end() &&
           count >= (open ? 2 : least) && count <= most;
}

void QuadHalfEdges::smooth() {
    std::vector<Vec> moved = mesh_.points;
    for (int v = 0; v < int(moved.size()); ++v) {
        if (!exists(v) || rank(v)) continue;
        Vec sum{}, normal{};
        double weight = 0;
        around(v, [&](int h) {
            const Vec& ahead = point(target(h));
            sum = sum + ahead + kAcross * point(origin(opposite(h)));
            normal = normal + cross(ahead - point(v), point(origin(previous(h))) - point(v));
            weight += 1 + kAcross;
        });
        Vec step = (1 / weight) * sum - point(v);
        const double square = dot(normal, normal);
        if (square > 0) step = step - (dot(step, normal) / square) * normal;
        const Vec goal = point(v) + kStep * step;
        const double near = std::max(squared(kNear * size(v)), quadric_[v].mean(point(v)));
        if (quadric_[v].mean(goal) <= near) moved[v] = goal;
    }
    mesh_.points.swap(moved);
}

}  // namespace henkei
