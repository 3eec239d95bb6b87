// Arrays that may grow to gigabytes: on huge pages where the system has them, for far fewer page
// faults and cache misses of the page table.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <new>
#include <utility>
#include <vector>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace henkei {

template <class T>
struct HugePages {
    using value_type = T;
    static constexpr size_t kPage = size_t(1) << 21;

    HugePages() = default;
    template <class U>
    HugePages(const HugePages<U>&) {}

    T* allocate(size_t count) {
        size_t bytes = count * sizeof(T);
        void* memory;
#ifdef MADV_HUGEPAGE
        if (bytes >= 4 * kPage) {
            bytes = (bytes + kPage - 1) / kPage * kPage;
            memory = std::aligned_alloc(kPage, bytes);
            if (memory != nullptr) madvise(memory, bytes, MADV_HUGEPAGE);
        } else
#endif
            memory = std::malloc(bytes > 0 ? bytes : 1);
        if (memory == nullptr) throw std::bad_alloc();
        return static_cast<T*>(memory);
    }
    void deallocate(T* memory, size_t) { std::free(memory); }

    template <class U>
    bool operator==(const HugePages<U>&) const {
        return true;
    }
    template <class U>
    bool operator!=(const HugePages<U>&) const {
        return false;
    }
};

template <class T>
using Array = std::vector<T, HugePages<T>>;

// An array that starts unfilled, for what is written once from end to end.
template <class T>
class Unfilled {
  public:
    using value_type = T;

    explicit Unfilled(size_t size = 0) : size_(size), data_(HugePages<T>().allocate(size)) {}
    Unfilled(Unfilled&& other) noexcept
        : size_(std::exchange(other.size_, 0)), data_(std::exchange(other.data_, nullptr)) {}
    Unfilled& operator=(Unfilled&& other) noexcept {
        std::swap(size_, other.size_);
        std::swap(data_, other.data_);
        return *this;
    }
    ~Unfilled() { HugePages<T>().deallocate(data_, size_); }

    size_t size() const { return size_; }
    T* data() { return data_; }

  private:
    size_t size_;
    T* data_;
};

}  // namespace henkei
