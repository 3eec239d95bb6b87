// Chords of a quad mesh, rows of quads from side to opposite side, collapsed where they are thin:
// J. Daniels, C. Silva, J. Shepherd, E. Cohen, "Quadrilateral mesh simplification", 2008; M.
// Borden, S. Benzley, J. Shepherd, "Hexahedral sheet extraction", 2002.
//
// A chord that is thin in places may run all over the surface. So parts of chords are collapsed,
// too: the vertices on one side of the part become one with those on the other, each with that one
// step further on, so that it closes like a zip at both ends. There, two vertices beside the chord
// lose an edge, and two on it get one more: ends lie best where valences are too high or too low.
//
// Of all parts the one with the most gain is collapsed: each quad gains by how much thinner it is
// than asked for, and loses by the distance that the surface is moved and by irregular vertices.
// When none is left that gains, more is asked for.
#include "quad_chords.hpp"

#include <cmath>
#include <utility>

#include "kernels.hpp"

namespace henkei {
namespace {

constexpr double kThin = 0.3, kWidest = 3.0;  // widths asked for, first and last, in wished edges
constexpr double kMore = 1.05;                // times as much at every turn
constexpr int kSmoothings = 2;                // at every turn
constexpr double kIrregular = 3.0;            // cost of the squared excess of a valence, in quads
constexpr double kSlanted = 0.4;              // cost of a quad that gets more slanted
constexpr double kMoved = 8.0;                // cost of a squared distance, in wished edges
constexpr double kBelow = 0.02;               // part of the quads by which there may be too few
constexpr int kHighest = 6, kLeast = 3, kLeastOnBorder = 2;  // valences
constexpr int64_t kFewest = 3;                               // quads left at least

// How the vertices of both sides become one: with those opposite, or with those one step further.
enum Way { kStraight, kLeftAhead, kRightAhead, kWays };

struct Collapse {
    double gain = 0;
    Way way = kStraight;
    std::vector<int> entries;  // half-edges over which the quads are entered
    bool closed = false;
};

double squared(int value) {
    return double(value) * value;
}

// What is known of a quad as long as it stays as it is. Index 0 and 1: entered over an even or over
// an odd half-edge; the diagonal from an even or from an odd corner.
struct Shape {
    double width[2];  // in wished edges
    double slant;     // cosine of the angle between its middle lines, entered over an even one
    double harm[2];   // see QuadHalfEdges
    bool known = false;
};

class Collapsing {
  public:
    explicit Collapsing(QuadsWithSizes quads) : mesh_(std::move(quads)) {
        const size_t half_edges = mesh_.quads().origin.size();
        shapes_.resize(half_edges / 4);
        refused_.assign(half_edges, {});
        passed_.assign(half_edges, 0);
        seen_.assign(mesh_.quads().points.size(), {0, 0});
    }

    CollapsedQuads run(int64_t target);

  private:
    using Mesh = QuadHalfEdges;

    Collapse best(int64_t most);
    void follow(int h, std::vector<int>& entries, bool& closed);
    void consider_part(const std::vector<int>& entries, bool closed, Way way, int64_t most,
                       Collapse& best);
    void consider_whole(const std::vector<int>& entries, bool closed, int64_t most, Collapse& best);
    bool done(const Collapse& collapse);
    void forget(int v);
    const Shape& shape(int quad);
    double gain(int h, Way way);
    double cost(int excess) const { return kIrregular * squared(excess); }
    bool may_lose_an_edge(int v) const { return mesh_.rank(v) == 0 && mesh_.valence(v) > kLeast; }

    Mesh mesh_;
    std::vector<Shape> shapes_;
    std::vector<std::array<uint8_t, kWays>> refused_;  // quads entered over each half-edge, in vain
    std::vector<uint8_t> passed_;
    std::vector<std::pair<uint32_t, int>> seen_;  // of each vertex: in which search, and where last
    uint32_t search_ = 0;
    double thin_ = kThin;
};

CollapsedQuads Collapsing::run(int64_t target) {
    CollapsedQuads result;
    const int64_t least = std::max<int64_t>(kFewest, std::llround((1 - kBelow) * double(target)));
    while (mesh_.count() > target && thin_ < kWidest) {
        check_interrupt();
        const Collapse collapse = best(mesh_.count() - least);
        if (!collapse.entries.empty()) {
            result.chords += done(collapse);
            continue;
        }
        thin_ *= kMore;
        for (int i = 0; i < kSmoothings; ++i) mesh_.smooth();
        for (Shape& one : shapes_) one.known = false;
        std::fill(refused_.begin(), refused_.end(), std::array<uint8_t, kWays>{});
    }
    const QuadsWithSizes& quads = mesh_.quads();
    for (const Vec& p : quads.points) result.points.insert(result.points.end(), p.begin(), p.end());
    for (int quad = 0; quad < int(shapes_.size()); ++quad) {
        if (!mesh_.alive(quad)) continue;
        result.numbers.push_back(quad);
        for (int h = 4 * quad; h < 4 * quad + 4; ++h) {
            result.quads.push_back(quads.origin[h]);
            result.feature.push_back(uint8_t(quads.feature[h]));
        }
    }
    return result;
}

// The collapse of at most so many quads that gains most; without entries if none gains.
Collapse Collapsing::best(int64_t most) {
    Collapse best;
    std::vector<int> entries;
    bool closed = false;
    std::fill(passed_.begin(), passed_.end(), 0);
    for (const bool from_border : {true, false}) {
        for (int h = 0; h < int(passed_.size()); ++h) {
            if (!mesh_.alive(h / 4) || passed_[h]) continue;
            if (from_border && mesh_.twin(h) >= 0) continue;
            follow(h, entries, closed);
            consider_part(entries, closed, kLeftAhead, most, best);
            consider_part(entries, closed, kRightAhead, most, best);
            consider_whole(entries, closed, most, best);
        }
    }
    return best;
}

void Collapsing::follow(int h, std::vector<int>& entries, bool& closed) {
    entries.clear();
    const int first = h;
    do {
        entries.push_back(h);
        passed_[h] = passed_[Mesh::opposite(h)] = 1;
        h = mesh_.twin(Mesh::opposite(h));
    } while (h >= 0 && h != first);
    closed = h == first;
}

const Shape& Collapsing::shape(int quad) {
    Shape& known = shapes_[quad];
    if (known.known) return known;
    int v[4];
    double size = 0;
    for (int i = 0; i < 4; ++i) {
        v[i] = mesh_.origin(4 * quad + i);
        size += mesh_.size(v[i]) / 4;
    }
    const auto side = [&](int i) { return mesh_.point(v[(i + 1) & 3]) - mesh_.point(v[i & 3]); };
    const double area = length(cross(side(0) + side(1), side(1) + side(2))) / 2;
    for (int i = 0; i < 2; ++i) {
        const double across = (length(side(i)) + length(side(i + 2))) / 2;
        const double along = (length(side(i + 1)) + length(side(i + 3))) / 2;
        known.width[i] = (along > 0 ? std::min(across, area / along) : across) / size;
        known.harm[i] = mesh_.harm(v[i], v[i + 2]);
    }
    const Vec onwards = side(1) - side(3), right = side(0) - side(2);
    const double product = length(onwards) * length(right);
    known.slant = product > 0 ? dot(onwards, right) / product : 0;
    known.known = true;
    return known;
}

// Of the quad that is entered over a half-edge, but for valences.
double Collapsing::gain(int h, Way way) {
    const Shape& quad = shape(h / 4);
    const int odd = h & 1;
    const double slant = odd ? -quad.slant : quad.slant;
    const double gain = thin_ - quad.width[odd];
    if (way == kStraight) return gain;
    const bool left = way == kLeftAhead;
    return gain - (left ? kSlanted : -kSlanted) * slant - kMoved * quad.harm[left ? odd : 1 - odd];
}

// The part of a chord whose collapse gains most: sums over parts are differences of sums from the
// beginning, and of the beginnings that are possible still the best is the first in a queue.
void Collapsing::consider_part(const std::vector<int>& entries, bool closed, Way way, int64_t most,
                               Collapse& best) {
    const int length = int(entries.size()), end = closed ? 2 * length : length;
    const int longest = int(std::min<int64_t>(most, length - 1));
    const bool left = way == kLeftAhead;
    std::vector<std::pair<double, int>> starts;  // gain of what is to come from there, and where
    size_t head = 0;
    int first = 0, chosen = -1, chosen_end = -1;  // no part may start before the first
    ++search_;
    const auto pass = [&](int a, int b, bool feature, int k) {
        for (const int v : {a, b}) {
            if (seen_[v].first == search_) first = std::max(first, seen_[v].second + 1);
            seen_[v] = {search_, k};
        }
        if (feature) first = std::max(first, k + 1);
    };
    pass(mesh_.origin(entries[0]), mesh_.target(entries[0]), mesh_.feature(entries[0]), 0);
    double sum = 0;
    for (int k = 0; k < end; ++k) {
        const int h = entries[k % length], exit = Mesh::opposite(h);
        const int before = left ? mesh_.target(h) : mesh_.origin(h);
        const int after = left ? mesh_.target(exit) : mesh_.origin(exit);
        const int a = left ? mesh_.origin(h) : mesh_.target(h);
        const int b = left ? mesh_.origin(exit) : mesh_.target(exit);
        const int excess = mesh_.excess(a) + mesh_.excess(b);
        const int valence = mesh_.wished(mesh_.border(a) ? a : b) + excess;
        const bool border = mesh_.border(a) || mesh_.border(b);
        const bool refused = (mesh_.rank(a) && mesh_.rank(b)) || refused_[h][way];
        const double base = gain(h, way) + cost(mesh_.excess(a)) + cost(mesh_.excess(b));
        const auto end_gain = [&](int v) {
            return cost(mesh_.excess(v)) - cost(mesh_.excess(v) - 1);
        };
        if (!refused && may_lose_an_edge(before) && valence < kHighest && !mesh_.feature(h)) {
            const double start = end_gain(before) + cost(excess) - cost(excess + 1) - sum;
            while (starts.size() > head && starts.back().first <= start) starts.pop_back();
            starts.emplace_back(start, k);
        }
        pass(mesh_.origin(exit), mesh_.target(exit), mesh_.feature(exit), k + 1);
        if (refused) first = k + 1;
        while (head < starts.size() &&
               (starts[head].second < first || k + 1 - starts[head].second > longest)) {
            ++head;
        }
        if (head < starts.size() && may_lose_an_edge(after) && valence < kHighest) {
            const int start = starts[head].second;
            const bool alone = start == k;
            double total = end_gain(after) + base - cost(excess + (alone ? 2 : 1));
            total += alone ? end_gain(before) : starts[head].first + sum;
            if (total > best.gain && (!alone || valence + 2 <= kHighest)) {
                best.gain = total;
                chosen = start;
                chosen_end = k + 1;
            }
        }
        const int least = border ? kLeastOnBorder : kLeast;
        if (valence < least || valence > kHighest) first = std::max(first, k + 1);
        sum += base - cost(excess);
    }
    if (chosen < 0) return;
    best.way = way;
    best.closed = false;
    best.entries.clear();
    for (int k = chosen; k < chosen_end; ++k) best.entries.push_back(entries[k % length]);
}

// A chord that nowhere touches itself, as a whole.
void Collapsing::consider_whole(const std::vector<int>& entries, bool closed, int64_t most,
                                Collapse& best) {
    if (int64_t(entries.size()) > most) return;
    ++search_;
    double total = 0;
    const auto rung = [&](int h) {
        const int a = mesh_.origin(h), b = mesh_.target(h);
        for (const int v : {a, b}) {
            if (seen_[v].first == search_) return false;
            seen_[v].first = search_;
        }
        const int ranks = mesh_.rank(a) + mesh_.rank(b);
        if (mesh_.rank(a) && mesh_.rank(b) && (!mesh_.feature(h) || ranks == 4)) return false;
        const bool both = mesh_.border(a) && mesh_.border(b);
        const int wished =
            both ? mesh_.wished(a) + mesh_.wished(b) - 3 : mesh_.wished(mesh_.border(a) ? a : b);
        const int excess = mesh_.excess(a) + mesh_.excess(b), valence = wished + excess;
        const bool border = mesh_.border(a) || mesh_.border(b);
        total += cost(mesh_.excess(a)) + cost(mesh_.excess(b)) - cost(excess);
        total -= kMoved * mesh_.harm(a, b);
        return valence >= (border ? kLeastOnBorder : kLeast) && valence <= kHighest;
    };
    for (const int h : entries) {
        if (refused_[h][kStraight] || !rung(h)) return;
        if (mesh_.feature(Mesh::next(h)) && mesh_.feature(Mesh::previous(h))) return;
        total += gain(h, kStraight);
    }
    if (!closed && !rung(Mesh::opposite(entries.back()))) return;
    if (total > best.gain) best = {total, kStraight, entries, closed};
}

// Collapses, unless what comes out is no proper mesh; then a quad of the chord is refused.
bool Collapsing::done(const Collapse& collapse) {
    std::vector<int> touched;
    int highest = kHighest, least = kLeast;
    for (const int h : collapse.entries) {
        for (const int side : {h, Mesh::opposite(h)}) {
            for (const int v : {mesh_.origin(side), mesh_.target(side)}) {
                touched.push_back(v);
                highest = std::max(highest, mesh_.valence(v));
                least = std::min(least, mesh_.valence(v));
            }
        }
    }
    int faulty = -1;  // an entry
    if (collapse.way == kStraight) {
        if (!mesh_.collapse_row(collapse.entries, collapse.closed)) faulty = 0;
    } else {
        for (size_t k = 0; k < collapse.entries.size() && faulty < 0; ++k) {
            const int h = collapse.entries[k];
            const int corner = collapse.way == kLeftAhead ? h : Mesh::next(h);
            if (!mesh_.collapse_diagonal(corner)) faulty = int(k);
        }
    }
    for (size_t i = 0; i < touched.size() && faulty < 0; ++i) {
        const int v = touched[i];
        if (mesh_.exists(v) && !mesh_.check(v, least, highest)) faulty = int(i / 4);
    }
    if (faulty >= 0) {
        mesh_.undo();
        refused_[collapse.entries[faulty]][collapse.way] = 1;
        return false;
    }
    mesh_.commit();
    for (const int v : touched) forget(v);
    return true;
}

void Collapsing::forget(int v) {
    if (!mesh_.exists(v)) return;
    mesh_.around(v, [&](int h) { shapes_[h / 4].known = false; });
}

}  // namespace

CollapsedQuads collapse_chords(QuadsWithSizes quads, int64_t target) {
    return Collapsing(std::move(quads)).run(target);
}

}  // namespace henkei
