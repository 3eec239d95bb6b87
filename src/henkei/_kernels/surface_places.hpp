// Points that move along a triangle mesh: each keeps the face that it is on.
#pragma once

#include <cstdint>
#include <vector>

#include "sphere.hpp"

namespace henkei {

struct WalkedPlace {
    int32_t face;
    Vec weights, point;
};

class SurfacePlaces {
  public:
    // twins: of half-edges, negative where there is none, or where no point may cross.
    SurfacePlaces(const double* vertices, int64_t vertex_count, const int32_t* faces,
                  const int32_t* twins, int64_t face_count);

    WalkedPlace at(int32_t face, const Vec& weights) const;
    // The nearest place to `to` among the faces that can be reached from `from` without going
    // farther from `to` than `from` is. So no point comes to another sheet that is near in space.
    WalkedPlace moved(const WalkedPlace& from, const Vec& to);
    // Interpolated between the corners of the face; where no point may cross, sides differ.
    Vec normal(const WalkedPlace& place) const;
    const Vec& face_normal(int32_t face) const { return face_normal_[face]; }

  private:
    void set_normals();
    // Nearest point of a face; gives its squared distance.
    double nearest(int32_t face, const Vec& to, WalkedPlace& place) const;

    std::vector<Vec> point_, normal_, face_normal_;  // normals of corners, 3 a face
    std::vector<int32_t> faces_, twins_, open_;
    std::vector<uint32_t> seen_;
    uint32_t round_ = 0;
};

}  // namespace henkei
