// Elimination tree, column counts and panels of a sparse Cholesky factor.
// Liu, "The role of elimination trees in sparse factorization", SIAM J. Matrix Anal. Appl. 11,
// 1990; Gilbert, Ng, Peyton, "An efficient algorithm to compute row and column counts for sparse
// Cholesky factorization", SIAM J. Matrix Anal. Appl. 15, 1994; Ashcraft, Grimes, "The influence of
// relaxed supernode partitions on the multifrontal method", ACM Trans. Math. Softw. 15, 1989.
#include "elimination.hpp"

#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "kernels.hpp"
#include "panels.hpp"

namespace henkei {

namespace {

using Ints = std::vector<int32_t>;

constexpr int32_t kNone = -1;
constexpr int32_t kNarrow = 4;  // columns up to which panels are joined at any cost in zeros
// Panels of up to so many columns are joined if at most this part of their values is zero.
constexpr struct {
    int32_t columns;
    double zeros;
} kRelaxed[] = {{16, 0.25}, {48, 0.1}, {1 << 30, 0.03}};

Ints inverse(const Ints& order) {
    Ints position(order.size());
    for (size_t k = 0; k < order.size(); ++k) position[order[k]] = int32_t(k);
    return position;
}

// The entries above the diagonal, column after column in the order of elimination.
struct Upper {
    std::vector<int64_t> start;
    Ints row;

    Upper(const Pattern& pattern, const Ints& order, const Ints& position) : start(1, 0) {
        start.reserve(order.size() + 1);
        row.reserve(size_t(pattern.start[pattern.size]) / 2);
        for (size_t j = 0; j < order.size(); ++j) {
            for (int32_t e = pattern.start[order[j]]; e < pattern.start[order[j] + 1]; ++e) {
                const int32_t i = position[pattern.row[e]];
                if (i < int32_t(j)) row.push_back(i);
            }
            start.push_back(int64_t(row.size()));
        }
    }
};

// The parent of each column: the first row below the diagonal in which the factor is not zero.
Ints elimination_tree(const Upper& upper) {
    const int32_t size = int32_t(upper.start.size() - 1);
    Ints parent(size, kNone), ancestor(size, kNone);
    for (int32_t j = 0; j < size; ++j) {
        for (int64_t e = upper.start[j]; e < upper.start[j + 1]; ++e) {
            int32_t i = upper.row[e];
            while (ancestor[i] != kNone && ancestor[i] != j) {
                const int32_t next = ancestor[i];
                ancestor[i] = j;
                i = next;
            }
            if (ancestor[i] == kNone) ancestor[i] = parent[i] = j;
        }
    }
    return parent;
}

// Columns so that each subtree is consecutive and ends at its root; of siblings the one with the
// largest key comes last, next to its parent.
Ints postorder(const Ints& parent, const Ints& key) {
    const int32_t size = int32_t(parent.size());
    Ints sorted(size);
    std::iota(sorted.begin(), sorted.end(), 0);
    std::stable_sort(sorted.begin(), sorted.end(),
                     [&](int32_t a, int32_t b) { return key[a] > key[b]; });
    Ints child(size + 1, kNone), sibling(size, kNone), order, stack;
    for (int32_t j : sorted) {
        int32_t& head = child[parent[j] == kNone ? size : parent[j]];
        sibling[j] = head;
        head = j;
    }
    order.reserve(size);
    stack.push_back(size);
    while (!stack.empty()) {
        const int32_t j = stack.back();
        if (child[j] != kNone) {
            stack.push_back(child[j]);
            child[j] = sibling[child[j]];
        } else {
            stack.pop_back();
            if (j < size) order.push_back(j);
        }
    }
    return order;
}

// Entries of each column of the factor, the diagonal included. The columns are in postorder.
Ints column_counts(const Pattern& pattern, const Ints& order, const Ints& position,
                   const Ints& parent) {
    const int32_t size = pattern.size;
    Ints count(size, 0), earliest(size), latest(size, kNone), leaf(size, kNone), ancestor(size);
    std::iota(earliest.begin(), earliest.end(), 0);
    std::iota(ancestor.begin(), ancestor.end(), 0);
    for (int32_t j = 0; j < size; ++j) {
        if (earliest[j] == j) count[j] = 1;  // a leaf of the tree
        if (parent[j] != kNone) earliest[parent[j]] = std::min(earliest[parent[j]], earliest[j]);
    }
    for (int32_t j = 0; j < size; ++j) {
        if (parent[j] != kNone) --count[parent[j]];
        for (int32_t e = pattern.start[order[j]]; e < pattern.start[order[j] + 1]; ++e) {
            const int32_t i = position[pattern.row[e]];
            if (i <= j || earliest[j] <= latest[i]) continue;  // no leaf of row i's subtree
            ++count[j];
            if (leaf[i] != kNone) {
                int32_t meet = leaf[i];  // of the paths from both leaves up to i
                while (ancestor[meet] != meet) meet = ancestor[meet] = ancestor[ancestor[meet]];
                --count[meet];
            }
            leaf[i] = j;
            latest[i] = j;
        }
        if (parent[j] != kNone) ancestor[j] = parent[j];
    }
    for (int32_t j = 0; j < size; ++j) {
        if (parent[j] != kNone) count[parent[j]] += count[j];
    }
    return count;
}

// First columns of the supernodes: columns of one structure, or almost.
Ints supernodes(const Ints& parent, const Ints& count) {
    const int32_t size = int32_t(parent.size());
    Ints children(size, 0);
    for (int32_t up : parent) {
        if (up != kNone) ++children[up];
    }
    struct Group {
        int32_t first, end;
        int64_t zeros;
    };
    const auto height = [&](const Group& group) {
        return int64_t(group.end - group.first) + count[group.end - 1] - 1;
    };
    std::vector<Group> groups;  // the last group found is on top
    for (int32_t end = size; end > 0;) {
        int32_t first = end - 1;
        while (first > 0 && parent[first - 1] == first && children[first] == 1 &&
               count[first - 1] == count[first] + 1) {
            --first;
        }
        Group group{first, end, 0};
        while (!groups.empty() && parent[group.end - 1] == groups.back().first) {
            const Group& above = groups.back();
            Group joined{group.first, above.end, group.zeros + above.zeros};
            const int64_t columns = joined.end - joined.first;
            joined.zeros += (group.end - group.first) * (height(joined) - height(group));
            const double all = double(columns) * (double(height(joined)) - (columns - 1) / 2.0);
            bool join = columns <= kNarrow;
            for (const auto& rule : kRelaxed) {
                join |= columns <= rule.columns && joined.zeros < rule.zeros * all;
            }
            if (!join) break;
            group = joined;
            groups.pop_back();
        }
        groups.push_back(group);
        end = first;
    }
    Ints result;
    for (size_t g = groups.size(); g-- > 0;) result.push_back(groups[g].first);
    result.push_back(size);
    return result;
}

// A pattern's elimination tree, in a postorder of it.
struct Tree {
    Ints order, position, parent, count;

    Tree(const Pattern& pattern, const int32_t* given)
        : order(given, given + pattern.size), position(inverse(order)), count(pattern.size, 0) {
        parent = elimination_tree(Upper(pattern, order, position));
        arrange(postorder(parent, count));
        count = column_counts(pattern, order, position, parent);
        arrange(postorder(parent, count));
    }

    void arrange(const Ints& post) {
        const Ints place = inverse(post);
        Ints new_order(post.size()), new_parent(post.size()), new_count(post.size());
        for (size_t j = 0; j < post.size(); ++j) {
            const int32_t up = parent[post[j]];
            new_order[j] = order[post[j]];
            new_parent[j] = up == kNone ? kNone : place[up];
            new_count[j] = count[post[j]];
        }
        order.swap(new_order);
        parent.swap(new_parent);
        count.swap(new_count);
        position = inverse(order);
    }
};

// Rows of each supernode's first column, less the diagonal, from at[supernode] on.
void find_rows(const Pattern& pattern, const Tree& tree, const Ints& first,
               std::vector<int64_t>& at, Ints& rows) {
    const int32_t supernodes = int32_t(first.size() - 1);
    Ints holder(pattern.size), up(supernodes, kNone), seen(supernodes, kNone);
    at.assign(1, 0);
    for (int32_t s = 0; s < supernodes; ++s) {
        std::fill(holder.begin() + first[s], holder.begin() + first[s + 1], s);
        at.push_back(at[s] + first[s + 1] - first[s] - 1 + tree.count[first[s + 1] - 1] - 1);
    }
    std::vector<int64_t> end(at.begin(), at.end() - 1);
    rows.resize(size_t(at.back()));
    for (int32_t s = 0; s < supernodes; ++s) {
        for (int32_t j = first[s] + 1; j < first[s + 1]; ++j) rows[end[s]++] = j;
        const int32_t parent = tree.parent[first[s + 1] - 1];
        if (parent != kNone) up[s] = holder[parent];
    }
    // Row i is in the supernodes on the ways up from those of its entries to its own.
    for (int32_t i = 0; i < pattern.size; ++i) {
        const int32_t entry = tree.order[i];
        for (int32_t e = pattern.start[entry]; e < pattern.start[entry + 1]; ++e) {
            const int32_t j = tree.position[pattern.row[e]];
            if (j >= i) continue;
            for (int32_t s = holder[j]; s != holder[i] && seen[s] != i; s = up[s]) {
                if (end[s] == at[s + 1]) throw std::invalid_argument("pattern not symmetric");
                seen[s] = i;
                rows[end[s]++] = i;
            }
        }
    }
}

}  // namespace

Panels find_panels(const Pattern& pattern, const int32_t* order) {
    Panels panels;
    Tree tree(pattern, order);
    check_interrupt();
    const Ints first = supernodes(tree.parent, tree.count);
    std::vector<int64_t> at;
    find_rows(pattern, tree, first, at, panels.rows);
    check_interrupt();

    int64_t values = 0;
    for (size_t s = 0; s + 1 < first.size(); ++s) {
        const int32_t columns = first[s + 1] - first[s], parts = (columns - 1) / kWidest + 1;
        for (int32_t part = 0; part < parts; ++part) {
            const int32_t begin = int32_t(int64_t(columns) * part / parts);
            const int32_t end = int32_t(int64_t(columns) * (part + 1) / parts);
            const int32_t below = columns - end + tree.count[first[s + 1] - 1] - 1;
            panels.first.push_back(first[s] + begin);
            panels.below.push_back(below);
            panels.rows_at.push_back(at[s] + end - 1);
            panels.values_at.push_back(values);
            values += int64_t(end - begin) * (end - begin + below);
        }
    }
    panels.first.push_back(pattern.size);
    panels.values_at.push_back(values);
    panels.order = std::move(tree.order);
    panels.position = std::move(tree.position);
    return panels;
}

}  // namespace henkei
