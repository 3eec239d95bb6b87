// The motorcycle graph of a seamless map: from every singular vertex lines of constant u and of
// constant v run at equal speed until they meet the track of another (D. Eppstein, M. Goodrich,
// E. Kim, R. Tamstorf, "Motorcycle graphs: canonical quad mesh partitioning", 2008; M. Campen,
// D. Bommes, L. Kobbelt, "Quantized global parametrization", 2015).
//
// A line is traced from vertex to vertex: the one-ring of the vertex is unfolded by the
// coordinates, and the edge of its link is found over which the line leaves. That edge is split
// there, so that the track runs along edges; close to one of the edge's ends the track goes to that
// end instead, and how far that is off the line is remembered, so that errors do not add up.
#include "motorcycles.hpp"

#include <algorithm>
#include <cmath>
#include <queue>

#include "kernels.hpp"

namespace henkei {
namespace {

constexpr double kSnap = 0.2;      // part of an edge within which a track goes to the edge's end
constexpr double kClosest = 0.05;  // part of an edge that a split leaves at least
constexpr double kQuarter = 1.5707963267948966;

struct Change {
    double u, v;
    Change turned(int quarters) const {  // counter-clockwise
        switch (quarters & 3) {
            case 1:
                return {-v, u};
            case 2:
                return {-u, -v};
            case 3:
                return {v, -u};
            default:
                return {u, v};
        }
    }
};

double angle_between(Change a, Change b) {
    return std::atan2(a.u * b.v - a.v * b.u, a.u * b.u + a.v * b.v);
}

int next(int h) {
    return h % 3 == 2 ? h - 2 : h + 1;
}
int previous(int h) {
    return h % 3 == 0 ? h + 2 : h - 1;
}

struct Motorcycle {
    int32_t seat;   // half-edge that starts where it stands
    int8_t ahead;   // direction of its line in the seat's face
    double offset;  // how far it stands to the left of its line
    double time;
    bool done = false;
};

// One edge of the link of a vertex, seen along a line: ends right and left of it.
struct Exit {
    int32_t spoke = -1;          // half-edge from the vertex to the edge's right end
    int8_t ahead = 0;            // direction of the line in that half-edge's face
    double part = 0;             // where the line crosses the edge, from its right end
    double right = 0, left = 0;  // distance of its ends to the left of the line
    double way = -1e300;         // along the line
};

class Tracing {
  public:
    Tracing(TracedSurface surface, double meeting) : s(std::move(surface)), meeting(meeting) {
        const size_t n = s.vertices.size() / 3;
        out.assign(n, -1);
        on_track.assign(n, 0);
        standing.assign(n, -1);
        for (size_t h = 0; h < s.faces.size(); ++h) {
            const int v = s.faces[h];
            if (out[v] < 0 || s.twin[h] < 0) out[v] = int(h);
            if (s.track[h] >= 0) on_track[v] = on_track[target(int(h))] = 1;
        }
    }

    void start(int vertex, int face) {
        for (const Angle& angle : angles(vertex, face)) {
            const int undivided = face >= 0 ? 1 : 2;
            if (!angle.closed && angle.quarters <= undivided) continue;
            for (int k = angle.closed ? 0 : 1; k < angle.quarters; ++k)
                leave(angle.first, angle.axis + k);
        }
    }

    void run() {
        int64_t steps = 0;
        while (!queue.empty()) {
            const int id = queue.top().second;
            queue.pop();
            if ((++steps & 4095) == 0) check_interrupt();
            Motorcycle& m = riders[id];
            if (m.done) continue;
            standing[s.faces[m.seat]] = -1;
            if (meets(m)) continue;
            const Exit exit = way_ahead(m);
            if (exit.spoke < 0) {
                ++result.lost;
                continue;
            }
            go(m, exit, id);
        }
    }

    TracingResult finished() {
        result.turn.assign(s.faces.size(), 0);
        for (size_t h = 0; h < s.faces.size(); ++h)
            if (s.track[h] >= 0) result.turn[h] = int8_t(turn_at(int(h)));
        result.motorcycles = int64_t(riders.size());
        result.surface = std::move(s);
        return std::move(result);
    }

  private:
    // Between two tracks at a vertex, or all round it.
    struct Angle {
        int first;     // half-edge it starts with
        int quarters;  // how many quarter turns wide it is
        bool closed;   // all round
        double axis;   // quarter turns from the first half-edge to an axis next to it
    };

    TracedSurface s;
    double meeting;
    std::vector<int32_t> out, standing;
    std::vector<uint8_t> on_track;
    std::vector<Motorcycle> riders;
    using Entry = std::pair<double, int>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<Entry>> queue;
    TracingResult result;

    int target(int h) const { return s.faces[next(h)]; }
    Change change(int h) const { return {s.change[2 * h], s.change[2 * h + 1]}; }
    // The half-edge that follows counter-clockwise round its start, or -1 at the boundary.
    int around(int h) const { return s.twin[previous(h)]; }
    bool is_cut(int h) const { return s.track[h] >= 0; }

    Change ahead_of(int h, int ahead) const { return change(h).turned(-ahead); }

    // Direction of the axis nearest to a half-edge, in its face, and how far left of it it lies.
    double angle_of(int h) const {
        const Change c = change(h);
        return std::atan2(c.v, c.u) / kQuarter;
    }

    double corner(int h) const {
        const Change a = change(h), b = change(previous(h));
        return angle_between(a, {-b.u, -b.v}) / kQuarter;
    }

    // Those of a vertex, or the one that holds a face.
    std::vector<Angle> angles(int vertex, int face) const {
        std::vector<int> ring;
        int h = out[vertex];
        do {
            ring.push_back(h);
            h = around(h);
        } while (h >= 0 && h != out[vertex]);
        std::vector<Angle> found;
        const auto first = std::find_if(ring.begin(), ring.end(), [&](int g) { return is_cut(g); });
        if (first == ring.end()) {
            double total = 0;
            for (int g : ring) total += corner(g);
            const double at = angle_of(ring[0]);
            found.push_back({ring[0], int(std::lround(total)), true, std::ceil(at - 1e-9) - at});
            return found;
        }
        std::rotate(ring.begin(), ring.begin() + (first - ring.begin()), ring.end());
        for (size_t i = 0; i < ring.size();) {
            double total = 0;
            bool holds = false;
            size_t j = i;
            do {
                total += corner(ring[j]);
                holds |= ring[j] / 3 == face;
                ++j;
            } while (j < ring.size() && !is_cut(ring[j]));
            if (face < 0 || holds) {
                const double tilt = angle_of(ring[i]) - s.track[ring[i]];
                const double off = tilt - 4 * std::round(tilt / 4);
                found.push_back({ring[i], int(std::lround(total)), false, -off});
            }
            i = j;
        }
        return found;
    }

    // Starts a track that leaves `quarters` quarter turns counter-clockwise of a half-edge.
    void leave(int first, double quarters) {
        int h = first;
        double left = quarters;
        for (int guard = 0; guard < 100000; ++guard) {
            const double wide = corner(h);
            const int following = around(h);
            if (left < wide || following < 0 || following == first) break;
            left -= wide;
            h = following;
        }
        // The direction in the face's own frame: an axis.
        const int ahead = int(std::lround(angle_of(h) + left)) & 3;
        const int prev = previous(h);
        const Change a = ahead_of(h, ahead), b = ahead_of(prev, ahead);
        Exit exit{h, int8_t(ahead), 0, std::min(a.v, 0.0), std::max(-b.v, 0.0), 0};
        const double height = exit.left - exit.right;
        exit.part = height > 0 ? -exit.right / height : 0.5;
        exit.way = a.u + exit.part * (-b.u - a.u);
        riders.push_back({h, int8_t(ahead), 0, 0});
        const int id = int(riders.size()) - 1;
        Motorcycle m = riders[id];
        go(m, exit, id);
        riders[id] = m;
    }

    // Two that come towards each other on lines that quads cannot keep apart share one track.
    bool meets(Motorcycle& m) {
        int h = m.seat, ahead = m.ahead;
        do {
            const Change there = ahead_of(h, ahead);
            const int other = standing[target(h)];
            if (other >= 0 && there.u > 0 && !is_cut(h)) {
                const double apart = there.v + m.offset + riders[other].offset;
                if (std::abs(apart) < meeting && comes(other, h, ahead)) {
                    standing[target(h)] = -1;
                    riders[other].done = m.done = true;
                    mark(h, ahead, target(h));
                    return true;
                }
            }
            ahead += s.matching[previous(h)];
            h = around(h);
        } while (h >= 0 && h != m.seat);
        return false;
    }

    // Whether a rider at the end of a spoke runs against one that would come along the spoke.
    bool comes(int rider, int spoke, int ahead) const {
        const int back = s.twin[spoke];
        if (back < 0) return false;
        int here = ahead + s.matching[spoke];
        int h = back;
        do {
            if (h == riders[rider].seat) return ((riders[rider].ahead - here) & 3) == 2;
            here += s.matching[previous(h)];
            h = around(h);
        } while (h >= 0 && h != back);
        return false;
    }

    // Where the line leaves the one-ring. Where it misses all of the ring, since the motorcycle
    // stands off it, the end of a spoke that leads ahead and lies next to the line.
    Exit way_ahead(const Motorcycle& m) const {
        Exit best, nearest;
        double most = -1e300;
        int h = m.seat, ahead = m.ahead;
        Change right = ahead_of(h, ahead);
        const Change first = right;
        do {
            const int following = around(h);
            if (following < 0) return best;
            const int after = ahead + s.matching[previous(h)];
            const Change left = following == m.seat ? first : ahead_of(following, after);
            const double low = right.v + m.offset, high = left.v + m.offset;
            if (low < 0 && high >= 0) {
                const double part = low / (low - high);
                const double way = right.u + part * (left.u - right.u);
                if (way > best.way) best = {h, int8_t(ahead & 3), part, low, high, way};
            }
            const double merit = right.u - 2 * std::abs(low);
            if (merit > most && !is_cut(h)) {
                most = merit;
                nearest = {h, int8_t(ahead & 3), 0, low, high, right.u};
            }
            h = following;
            ahead = after;
            right = left;
        } while (h != m.seat);
        return best.spoke >= 0 ? best : nearest;
    }

    // Whether a track that arrives along a half-edge may end or go on at the half-edge's target.
    bool may_go_along(int spoke, int ahead) const {
        if (is_cut(spoke)) return false;
        const int vertex = target(spoke);
        if (s.kept_off[vertex]) return false;
        if (!on_track[vertex]) return true;
        // No track of the same family may be there.
        const int back = s.twin[spoke];
        if (back < 0) return false;
        int here = ahead + s.matching[spoke];
        int h = back;
        do {
            if (is_cut(h) && ((s.track[h] - here) & 1) == 0) return false;
            here += s.matching[previous(h)];
            h = around(h);
        } while (h >= 0 && h != back);
        if (h < 0) {
            here = ahead + s.matching[spoke];
            for (h = back; s.twin[h] >= 0;) {  // clockwise
                here += s.matching[h];
                h = next(s.twin[h]);
                if (is_cut(h) && ((s.track[h] - here) & 1) == 0) return false;
            }
        }
        return true;
    }

    void go(Motorcycle& m, const Exit& exit, int id) {
        const int spoke = exit.spoke, ahead = exit.ahead;
        const int link = next(spoke);
        m.time += std::max(exit.way, 0.0);
        const int left_spoke = around(spoke);
        const int left_ahead = ahead + s.matching[previous(spoke)];
        if (exit.part < kSnap && may_go_along(spoke, ahead)) {
            m.offset = exit.right;
            along(m, spoke, ahead, id);
        } else if (exit.part > 1 - kSnap && left_spoke >= 0 &&
                   may_go_along(left_spoke, left_ahead)) {
            m.offset = exit.left;
            along(m, left_spoke, left_ahead, id);
        } else {
            const double part = std::clamp(exit.part, kClosest, 1 - kClosest);
            m.offset = exit.right + part * (exit.left - exit.right);
            const bool stops = is_cut(link);
            if (stops && ((s.track[link] - ahead) & 1) == 0) ++result.merged;
            const int vertex = split(link, part);
            const int back = next(link);  // from the new vertex to where the track comes from
            mark(s.twin[back], ahead, vertex);
            m.seat = back;
            m.ahead = int8_t(ahead & 3);
            if (stops) return;
            standing[vertex] = id;
            queue.push({m.time, id});
        }
    }

    void along(Motorcycle& m, int spoke, int ahead, int id) {
        const int vertex = target(spoke), back = s.twin[spoke];
        const bool stops = on_track[vertex];
        m.seat = back;
        m.ahead = int8_t((ahead + s.matching[spoke]) & 3);
        mark(spoke, ahead, vertex);
        if (stops) return;
        standing[vertex] = id;
        queue.push({m.time, id});
    }

    void mark(int h, int ahead, int vertex) {
        const int back = s.twin[h];
        s.track[h] = int8_t(ahead & 3);
        s.track[back] = int8_t((ahead + s.matching[h] + 2) & 3);
        on_track[vertex] = on_track[s.faces[h]] = 1;
    }

    int split(int h, double part) {
        const int vertex = int(out.size()), g = s.twin[h];
        const int a = s.faces[h], b = target(h);
        for (int c = 0; c < 3; ++c)
            s.vertices.push_back(s.vertices[3 * a + c] +
                                 part * (s.vertices[3 * b + c] - s.vertices[3 * a + c]));
        out.push_back(-1);
        on_track.push_back(is_cut(h));
        standing.push_back(-1);
        s.kept_off.push_back(0);
        const int ahead_half = split_side(h, part, vertex);
        out[vertex] = ahead_half;
        if (g >= 0) {
            const int behind_half = split_side(g, 1 - part, vertex);
            s.twin[h] = behind_half;
            s.twin[behind_half] = h;
            s.twin[g] = ahead_half;
            s.twin[ahead_half] = g;
        }
        return vertex;
    }

    // Face (a, b, c) with h from a to b becomes (a, new, c) and (new, b, c); returns new -> b.
    int split_side(int h, double part, int vertex) {
        const int n = next(h), p = previous(h);
        const int made = int(s.faces.size());
        const Change whole = change(h), to_c = change(n), from_c = change(p);
        const int b = s.faces[n], c = s.faces[p];
        for (int v : {vertex, b, c}) s.faces.push_back(v);
        const Change rest = {(1 - part) * whole.u, (1 - part) * whole.v};
        const Change inner = {-from_c.u - part * whole.u, -from_c.v - part * whole.v};
        for (const Change& d : {rest, to_c, Change{-inner.u, -inner.v}}) {
            s.change.push_back(d.u);
            s.change.push_back(d.v);
        }
        // made: new -> b, made + 1: b -> c (was n), made + 2: c -> new
        for (int k : {s.twin[h], s.twin[n], n}) s.twin.push_back(k);
        for (int8_t k : {s.matching[h], s.matching[n], int8_t(0)}) s.matching.push_back(k);
        for (int8_t k : {s.track[h], s.track[n], int8_t(-1)}) s.track.push_back(k);
        for (uint8_t k : {s.feature[h], s.feature[n], uint8_t(0)}) s.feature.push_back(k);
        if (s.twin[made + 1] >= 0) s.twin[s.twin[made + 1]] = made + 1;
        if (out[b] == n) out[b] = made + 1;
        if (standing[b] >= 0 && riders[standing[b]].seat == n) riders[standing[b]].seat = made + 1;
        s.faces[n] = vertex;
        s.change[2 * h] = part * whole.u;
        s.change[2 * h + 1] = part * whole.v;
        s.change[2 * n] = inner.u;
        s.change[2 * n + 1] = inner.v;
        s.twin[n] = made + 2;
        s.matching[n] = 0;
        s.track[n] = -1;
        s.feature[n] = 0;
        return made;
    }

    // Quarter turns of the rim at the start of a half-edge on a track, the patch on the left.
    int turn_at(int h) const {
        double wide = 0;
        int turned = 0, g = h;
        while (true) {
            wide += corner(g);
            const int end = previous(g);
            if (is_cut(end)) {
                const int exact = (s.track[end] + 2 - turned - s.track[h]) & 3;
                return 2 - (exact + 4 * int(std::lround((wide - exact) / 4)));
            }
            turned += s.matching[end];
            g = s.twin[end];
        }
    }
};

}  // namespace

TracingResult trace_motorcycles(TracedSurface surface, const int32_t* starts, int64_t count,
                                double meeting) {
    Tracing tracing(std::move(surface), meeting);
    for (int64_t k = 0; k < count; ++k) tracing.start(starts[2 * k], starts[2 * k + 1]);
    tracing.run();
    return tracing.finished();
}

}  // namespace henkei
