// Approximate minimum degree ordering on the quotient graph.
// Amestoy, Davis, Duff, "An approximate minimum degree ordering algorithm", SIAM J. Matrix Anal.
// Appl. 17, 1996. An eliminated unknown becomes an element: a clique given by its members. Unknowns
// with the same neighbours are merged into one of greater weight. Ties go to the unknown that got
// its degree last, so the order is the same everywhere.
#include <algorithm>
#include <cmath>

#include "kernels.hpp"
#include "ordering.hpp"

namespace henkei {

namespace {

using Ints = std::vector<int32_t>;
constexpr int32_t kNone = -1;

class MinimumDegree {
  public:
    MinimumDegree(const Pattern& pattern, const uint8_t* later);
    Ints run();

  private:
    void set_dense_aside();
    void insert(int32_t i, int32_t degree);
    void remove(int32_t i);
    void eliminate(int32_t pivot);
    void gather(int32_t pivot);
    void measure_elements();
    void update(int32_t pivot, int32_t i);
    void merge_alike();
    bool alike(int32_t i, int32_t j) const;
    void join(int32_t i, int32_t into);

    bool waits(int32_t i) const { return later_ != nullptr && later_[i]; }

    int32_t size_;
    const uint8_t* later_;  // unknowns that are not to be eliminated, or null
    int32_t left_, lowest_ = 0;
    int64_t stamp_ = 1;
    // Neighbours of an unknown from start_ on: its elements, then other unknowns.
    std::vector<int64_t> start_;
    Ints list_, elements_, length_;
    // Of an unknown: how many it stands for (0: joined to another one or eliminated; negative while
    // it is a member of the element at hand).
    Ints weight_, degree_;
    std::vector<int64_t> member_start_;  // of an element, in members_
    Ints members_, member_count_;
    std::vector<int64_t> outside_;  // of an element: stamp, plus the weight outside the new one
    Ints head_, next_, last_;       // unknowns by degree
    Ints chain_, chain_end_;        // those that an unknown stands for
    Ints bucket_, bucket_next_;
    int64_t marks_ = 0;
    std::vector<int64_t> mark_;
    Ints pivots_, dense_, now_;
};

MinimumDegree::MinimumDegree(const Pattern& pattern, const uint8_t* later)
    : size_(pattern.size),
      later_(later),
      left_(pattern.size),
      start_(size_ + 1, 0),
      elements_(size_, 0),
      length_(size_),
      weight_(size_, 1),
      degree_(size_),
      member_start_(size_, 0),
      member_count_(size_, 0),
      outside_(size_, 0),
      head_(size_ + 1, kNone),
      next_(size_, kNone),
      last_(size_, kNone),
      chain_(size_, kNone),
      chain_end_(size_),
      bucket_(size_, kNone),
      bucket_next_(size_, kNone),
      mark_(size_, 0) {
    list_.reserve(size_t(pattern.start[size_]));
    for (int32_t i = 0; i < size_; ++i) {
        for (int32_t e = pattern.start[i]; e < pattern.start[i + 1]; ++e) {
            if (pattern.row[e] != i) list_.push_back(pattern.row[e]);
        }
        start_[i + 1] = int64_t(list_.size());
        length_[i] = int32_t(start_[i + 1] - start_[i]);
        chain_end_[i] = i;
    }
}

// Unknowns with very many neighbours come last: they would only slow the others' updates.
void MinimumDegree::set_dense_aside() {
    const double most = std::max(16.0, 10 * std::sqrt(double(size_)));
    for (int32_t i = 0; i < size_; ++i) {
        if (length_[i] > most) dense_.push_back(i);
    }
    std::stable_sort(dense_.begin(), dense_.end(),
                     [&](int32_t a, int32_t b) { return length_[a] < length_[b]; });
    for (int32_t i : dense_) weight_[i] = 0;
    left_ -= int32_t(dense_.size());
    for (int32_t i = 0; i < size_ && !dense_.empty(); ++i) {
        int64_t end = start_[i];
        for (int64_t e = start_[i]; e < start_[i + 1]; ++e) {
            if (weight_[list_[e]] != 0) list_[end++] = list_[e];
        }
        length_[i] = int32_t(end - start_[i]);
    }
}

void MinimumDegree::insert(int32_t i, int32_t degree) {
    degree_[i] = degree;
    if (waits(i)) return;
    next_[i] = head_[degree];
    last_[i] = kNone;
    if (head_[degree] != kNone) last_[head_[degree]] = i;
    head_[degree] = i;
    lowest_ = std::min(lowest_, degree);
}

void MinimumDegree::remove(int32_t i) {
    if (waits(i)) return;
    if (next_[i] != kNone) last_[next_[i]] = last_[i];
    (last_[i] == kNone ? head_[degree_[i]] : next_[last_[i]]) = next_[i];
}

// `into` stands for i as well from now on.
void MinimumDegree::join(int32_t i, int32_t into) {
    weight_[into] += weight_[i];
    weight_[i] = 0;
    chain_[chain_end_[into]] = i;
    chain_end_[into] = chain_end_[i];
}

// Members of the new element: the pivot's neighbours, directly or through its elements.
void MinimumDegree::gather(int32_t pivot) {
    now_.clear();
    int32_t weight = 0;
    const auto take = [&](int32_t i) {
        if (weight_[i] <= 0) return;
        weight += weight_[i];
        weight_[i] = -weight_[i];
        remove(i);
        now_.push_back(i);
    };
    const int64_t begin = start_[pivot], middle = begin + elements_[pivot];
    for (int64_t e = begin; e < middle; ++e) {
        const int32_t element = list_[e];
        for (int32_t k = 0; k < member_count_[element]; ++k) {
            take(members_[member_start_[element] + k]);
        }
        outside_[element] = 0;  // absorbed
    }
    for (int64_t e = middle; e < begin + length_[pivot]; ++e) take(list_[e]);
    degree_[pivot] = weight;
}

// The weight of each neighbouring element's members that are not in the new one.
void MinimumDegree::measure_elements() {
    for (int32_t i : now_) {
        const int32_t weight = -weight_[i];
        for (int64_t e = start_[i]; e < start_[i] + elements_[i]; ++e) {
            const int32_t element = list_[e];
            if (outside_[element] >= stamp_) {
                outside_[element] -= weight;
            } else if (outside_[element] != 0) {
                outside_[element] = stamp_ + degree_[element] - weight;
            }
        }
    }
}

// Neighbours and degree of a member of the new element.
void MinimumDegree::update(int32_t pivot, int32_t i) {
    int64_t out = start_[i];
    const int64_t middle = out + elements_[i], end = out + length_[i];
    int64_t degree = 0;
    uint32_t hash = 0;
    for (int64_t e = start_[i]; e < middle; ++e) {
        const int32_t element = list_[e];
        if (outside_[element] == 0) continue;
        const int64_t outside = outside_[element] - stamp_;
        if (outside == 0) {
            outside_[element] = 0;  // within the new element: absorbed
            continue;
        }
        degree += outside;
        list_[out++] = element;
        hash += uint32_t(element);
    }
    const int64_t kept = out;
    for (int64_t e = middle; e < end; ++e) {
        const int32_t j = list_[e];
        if (weight_[j] <= 0) continue;
        degree += weight_[j];
        list_[out++] = j;
        hash += uint32_t(j);
    }
    // The new element goes between. There is room: the pivot or an element of its is gone.
    list_[out++] = list_[kept];
    list_[kept] = pivot;
    hash += uint32_t(pivot);
    elements_[i] = int32_t(kept - start_[i]) + 1;
    length_[i] = int32_t(out - start_[i]);
    if (length_[i] == 1 &&
        !waits(i)) {  // no neighbours outside: eliminated together with the pivot
        const int32_t weight = -weight_[i];
        degree_[pivot] -= weight;
        left_ -= weight;
        weight_[i] = 0;
        join(i, pivot);
        return;
    }
    degree_[i] = int32_t(std::min<int64_t>(degree_[i], degree));
    hash %= uint32_t(size_);
    bucket_next_[i] = bucket_[hash];
    bucket_[hash] = i;
    last_[i] = int32_t(hash);
}

// Whether i, whose neighbours are marked, has the same ones as j.
bool MinimumDegree::alike(int32_t i, int32_t j) const {
    if (length_[i] != length_[j] || elements_[i] != elements_[j] || waits(i) != waits(j)) {
        return false;
    }
    for (int64_t e = start_[j]; e < start_[j] + length_[j]; ++e) {
        if (mark_[list_[e]] != marks_) return false;
    }
    return true;
}

// Members with the same neighbours become one.
void MinimumDegree::merge_alike() {
    for (int32_t first : now_) {
        if (weight_[first] >= 0) continue;
        int32_t& bucket = bucket_[last_[first]];
        int32_t i = bucket;
        bucket = kNone;
        for (; i != kNone && bucket_next_[i] != kNone; i = bucket_next_[i]) {
            ++marks_;
            for (int64_t e = start_[i]; e < start_[i] + length_[i]; ++e) mark_[list_[e]] = marks_;
            int32_t before = i;
            for (int32_t j = bucket_next_[i]; j != kNone; j = bucket_next_[j]) {
                if (alike(i, j)) {
                    join(j, i);
                    bucket_next_[before] = bucket_next_[j];
                } else {
                    before = j;
                }
            }
        }
    }
}

void MinimumDegree::eliminate(int32_t pivot) {
    pivots_.push_back(pivot);
    left_ -= weight_[pivot];
    weight_[pivot] = 0;
    gather(pivot);
    measure_elements();
    outside_[pivot] = stamp_;  // an element from here on
    for (int32_t i : now_) update(pivot, i);
    merge_alike();
    member_start_[pivot] = int64_t(members_.size());
    for (int32_t i : now_) {
        if (weight_[i] == 0) continue;
        weight_[i] = -weight_[i];
        const int64_t degree = int64_t(degree_[i]) + degree_[pivot] - weight_[i];
        insert(i, int32_t(std::min<int64_t>(degree, left_ - weight_[i])));
        members_.push_back(i);
    }
    member_count_[pivot] = int32_t(int64_t(members_.size()) - member_start_[pivot]);
    stamp_ += int64_t(size_) + 1;
}

Ints MinimumDegree::run() {
    set_dense_aside();
    int32_t last = 0;
    for (int32_t i = size_; i-- > 0;) {
        if (weight_[i] == 0) continue;
        insert(i, length_[i]);
        last += waits(i);
    }
    lowest_ = 0;
    while (left_ > last) {
        while (head_[lowest_] == kNone) ++lowest_;
        const int32_t pivot = head_[lowest_];
        remove(pivot);
        eliminate(pivot);
        if (pivots_.size() % 65536 == 0) check_interrupt();
    }
    Ints order;
    order.reserve(size_);
    for (int32_t pivot : pivots_) {
        for (int32_t i = pivot; i != kNone; i = chain_[i]) order.push_back(i);
    }
    for (int32_t i : dense_) {
        if (!waits(i)) order.push_back(i);
    }
    return order;
}

}  // namespace

std::vector<int32_t> minimum_degree(const Pattern& pattern) {
    return minimum_degree_before(pattern, nullptr);
}

std::vector<int32_t> minimum_degree_before(const Pattern& pattern, const uint8_t* later) {
    return MinimumDegree(pattern, later).run();
}

}  // namespace henkei
