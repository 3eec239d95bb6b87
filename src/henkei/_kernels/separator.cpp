// Vertex separators by levels of coarser graphs.
// Hendrickson, Rothberg, "Improving the run time and quality of nested dissection ordering", SIAM
// J. Sci. Comput. 20, 1998; Karypis, Kumar, "A fast and high quality multilevel scheme for
// partitioning irregular graphs", SIAM J. Sci. Comput. 20, 1998; Fiduccia, Mattheyses, "A
// linear-time heuristic for improving network partitions", 1982. Vertices are matched along their
// strongest edges until few are left; a part is grown there; on the way back the separator is
// improved on each level by moving its vertices into a part, which draws their neighbours in.
#include "separator.hpp"

#include <algorithm>
#include <numeric>
#include <queue>
#include <utility>

#include "kernels.hpp"

namespace henkei {

namespace {

using Ints = std::vector<int32_t>;
using Parts = std::vector<int8_t>;

constexpr int32_t kNone = -1;
constexpr int32_t kCoarsest = 60;  // vertices of the coarsest graph
constexpr int kStarts = 8;         // parts that are grown on it
constexpr int kPasses = 4;         // over the separator, on each level
constexpr int32_t kPatience = 80;  // moves without a gain until a pass ends
constexpr double kLargest = 0.6;   // share of the larger part

// The vertex of a coarser graph that stands for each vertex: pairs along the strongest edges.
Ints matched(const Graph& graph, int32_t& count) {
    const int32_t size = graph.size();
    Ints order(size), mate(size, kNone), coarse(size);
    // Few neighbours first, or they are left alone; otherwise as they come.
    const auto degree = [&](int32_t v) {
        return std::min<int64_t>(graph.start[v + 1] - graph.start[v], 64);
    };
    std::vector<int32_t> place(66, 0);
    for (int32_t v = 0; v < size; ++v) ++place[degree(v) + 1];
    std::partial_sum(place.begin(), place.end(), place.begin());
    for (int32_t v = 0; v < size; ++v) order[place[degree(v)]++] = v;
    const int64_t total = std::accumulate(graph.weight.begin(), graph.weight.end(), int64_t(0));
    const int64_t heaviest = std::max<int64_t>(2, 3 * total / (2 * kCoarsest));
    for (int32_t v : order) {
        if (mate[v] != kNone) continue;
        int32_t best = v, strongest = 0;
        for (int64_t e = graph.start[v]; e < graph.start[v + 1]; ++e) {
            const int32_t u = graph.to[e];
            if (mate[u] == kNone && graph.strength[e] > strongest &&
                graph.weight[u] + graph.weight[v] <= heaviest) {
                best = u;
                strongest = graph.strength[e];
            }
        }
        mate[v] = best;
        mate[best] = v;
    }
    count = 0;
    for (int32_t v = 0; v < size; ++v) coarse[v] = mate[v] < v ? coarse[mate[v]] : count++;
    return coarse;
}

Graph contracted(const Graph& graph, const Ints& coarse, int32_t count) {
    Graph result;
    result.start.assign(1, 0);
    result.weight.assign(count, 0);
    result.to.reserve(graph.to.size() * 2 / 3);
    result.strength.reserve(graph.to.size() * 2 / 3);
    Ints second(count, kNone), first(count, kNone);
    std::vector<int64_t> at(count, -1);
    for (int32_t v = 0; v < graph.size(); ++v) {
        result.weight[coarse[v]] += graph.weight[v];
        (first[coarse[v]] == kNone ? first : second)[coarse[v]] = v;
    }
    for (int32_t c = 0; c < count; ++c) {
        const int64_t begin = int64_t(result.to.size());
        for (int32_t v : {first[c], second[c]}) {
            if (v == kNone) continue;
            for (int64_t e = graph.start[v]; e < graph.start[v + 1]; ++e) {
                const int32_t u = coarse[graph.to[e]];
                if (u == c) continue;
                if (at[u] < begin) {
                    at[u] = int64_t(result.to.size());
                    result.to.push_back(u);
                    result.strength.push_back(graph.strength[e]);
                } else {
                    result.strength[at[u]] += graph.strength[e];
                }
            }
        }
        result.start.push_back(int64_t(result.to.size()));
    }
    return result;
}

// A separator that can be improved.
class Separation {
  public:
    Separation(const Graph& graph, Parts part)
        : graph_(graph),
          part_(std::move(part)),
          beside_{Sums(graph.size()), Sums(graph.size())},
          moved_(graph.size(), 0),
          stamp_(graph.size(), 0) {
        for (int32_t v = 0; v < graph.size(); ++v) weight_[part_[v]] += graph.weight[v];
        most_ = int64_t(kLargest * double(weight_[0] + weight_[1] + weight_[2]));
    }

    // Small separators are good, and so are even parts.
    double cost() const {
        const double larger = double(std::max(weight_[0], weight_[1]));
        const double smaller = double(std::min(weight_[0], weight_[1]));
        const double uneven = larger > 0 ? (larger - smaller) / (larger + smaller) : 0;
        return double(weight_[2]) * (1 + uneven * uneven) +
               1e3 * double(std::max<int64_t>(0, int64_t(larger) - most_));
    }

    const Parts& part() const { return part_; }

    void improve() {
        for (int pass = 0; pass < kPasses; ++pass) {
            if (!improve_once()) break;
        }
    }

  private:
    using Sums = std::vector<int32_t>;
    struct Move {
        int64_t gain;
        int32_t vertex, stamp;
        bool operator<(const Move& other) const {
            return gain != other.gain ? gain < other.gain : vertex > other.vertex;
        }
    };

    int64_t gain(int32_t v, int side) const { return graph_.weight[v] - beside_[1 - side][v]; }

    void offer(int32_t v) {
        ++stamp_[v];
        for (int side : {0, 1}) moves_[side].push({gain(v, side), v, stamp_[v]});
    }

    void set(int32_t v, int8_t part) {
        history_.push_back({v, part_[v]});
        weight_[part_[v]] -= graph_.weight[v];
        weight_[part] += graph_.weight[v];
        part_[v] = part;
    }

    // The weight of the neighbours of a vertex of the separator in each part.
    void count_beside(int32_t v) {
        beside_[0][v] = beside_[1][v] = 0;
        for (int64_t e = graph_.start[v]; e < graph_.start[v + 1]; ++e) {
            const int32_t u = graph_.to[e];
            if (part_[u] != kSeparator) beside_[part_[u]][v] += graph_.weight[u];
        }
    }

    // A vertex leaves the separator for a part; its neighbours in the other part enter it.
    void move(int32_t v, int8_t side) {
        set(v, side);
        moved_[v] = pass_;
        for (int64_t e = graph_.start[v]; e < graph_.start[v + 1]; ++e) {
            const int32_t u = graph_.to[e];
            if (part_[u] == kSeparator) {
                beside_[side][u] += graph_.weight[v];
                if (moved_[u] != pass_) offer(u);
            }
        }
        for (int64_t e = graph_.start[v]; e < graph_.start[v + 1]; ++e) {
            const int32_t u = graph_.to[e];
            if (part_[u] != 1 - side) continue;
            set(u, kSeparator);
            for (int64_t f = graph_.start[u]; f < graph_.start[u + 1]; ++f) {
                const int32_t w = graph_.to[f];
                if (part_[w] != kSeparator) continue;
                beside_[1 - side][w] -= graph_.weight[u];
                if (moved_[w] != pass_) offer(w);
            }
            count_beside(u);
            if (moved_[u] != pass_) offer(u);
        }
    }

    // The best move that is still on offer, into the part where it gains more.
    bool next(int32_t& vertex, int8_t& side) {
        bool there[2];
        for (int s : {0, 1}) {
            auto& queue = moves_[s];
            while (!queue.empty() && (stamp_[queue.top().vertex] != queue.top().stamp ||
                                      part_[queue.top().vertex] != kSeparator ||
                                      moved_[queue.top().vertex] == pass_)) {
                queue.pop();
            }
            there[s] = !queue.empty() && (weight_[s] + graph_.weight[queue.top().vertex] <= most_ ||
                                          weight_[s] < weight_[1 - s]);
        }
        if (!there[0] && !there[1]) return false;
        side = there[0] ? 0 : 1;
        if (there[0] && there[1]) {
            const int64_t a = moves_[0].top().gain, b = moves_[1].top().gain;
            side = a != b ? int8_t(a < b) : int8_t(weight_[1] < weight_[0]);
        }
        vertex = moves_[side].top().vertex;
        return true;
    }

    bool improve_once() {
        ++pass_;
        history_.clear();
        moves_[0] = moves_[1] = {};
        for (int32_t v = 0; v < graph_.size(); ++v) {
            if (part_[v] != kSeparator) continue;
            count_beside(v);
            offer(v);
        }
        const double before = cost();
        double best = before;
        size_t keep = 0;
        int32_t vertex, waited = 0;
        int8_t side;
        while (waited < kPatience && next(vertex, side)) {
            move(vertex, side);
            ++waited;
            if (cost() < best) {
                best = cost();
                keep = history_.size();
                waited = 0;
            }
        }
        while (history_.size() > keep) {
            const auto [v, part] = history_.back();
            history_.pop_back();
            weight_[part_[v]] -= graph_.weight[v];
            weight_[part] += graph_.weight[v];
            part_[v] = part;
        }
        return best < before;
    }

    const Graph& graph_;
    Parts part_;
    Sums beside_[2];
    int64_t weight_[3] = {0, 0, 0}, most_;
    Ints moved_, stamp_;  // the pass in which a vertex was moved; its latest offer
    int32_t pass_ = 0;
    std::priority_queue<Move> moves_[2];
    std::vector<std::pair<int32_t, int8_t>> history_;
};

// Vertices around one until half of the weight is reached, with what lies next to them between.
Parts grown(const Graph& graph, int32_t from) {
    const int64_t total = std::accumulate(graph.weight.begin(), graph.weight.end(), int64_t(0));
    Parts part(graph.size(), 1);
    Ints front;
    int64_t reached = 0;
    const auto take = [&](int32_t v) {
        part[v] = 0;
        reached += graph.weight[v];
        front.push_back(v);
    };
    int32_t next = 0;
    while (2 * reached < total) {
        take(front.empty() ? from : next);  // then another connected piece
        for (size_t k = front.size() - 1; k < front.size() && 2 * reached < total; ++k) {
            for (int64_t e = graph.start[front[k]]; e < graph.start[front[k] + 1]; ++e) {
                if (part[graph.to[e]] == 1 && 2 * reached < total) take(graph.to[e]);
            }
        }
        while (next < graph.size() && part[next] == 0) ++next;
    }
    for (int32_t v : front) {
        for (int64_t e = graph.start[v]; e < graph.start[v + 1]; ++e) {
            if (part[graph.to[e]] == 1) part[v] = kSeparator;
        }
    }
    return part;
}

Parts separated_directly(const Graph& graph) {
    Parts best;
    double least = 0;
    for (int start = 0; start < kStarts; ++start) {
        Separation separation(graph,
                              grown(graph, int32_t(int64_t(graph.size()) * start / kStarts)));
        separation.improve();
        if (best.empty() || separation.cost() < least) {
            least = separation.cost();
            best = separation.part();
        }
    }
    return best;
}

}  // namespace

std::vector<int8_t> separate(const Graph& graph) {
    check_interrupt();
    if (graph.size() <= kCoarsest) return separated_directly(graph);
    int32_t count = 0;
    const Ints coarse = matched(graph, count);
    if (count > graph.size() / 10 * 9) return separated_directly(graph);
    const Parts coarse_part = separate(contracted(graph, coarse, count));
    Parts part(graph.size());
    for (int32_t v = 0; v < graph.size(); ++v) part[v] = coarse_part[coarse[v]];
    Separation separation(graph, std::move(part));
    separation.improve();
    return separation.part();
}

}  // namespace henkei
