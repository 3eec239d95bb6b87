// Arrays that may grow to gigabytes: on huge pages where the system has them, for far fewer page
// faults and cache misses of the page table.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <new>
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
            memory = std::malloc(bytes);
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

}  // namespace henkei
