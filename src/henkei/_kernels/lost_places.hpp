// Places of a surface that the faces of an approximation represent worst, a few for each face.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sphere.hpp"

namespace henkei {

// A face as it would be: its number, its vertices, and where they are.
struct FaceShape {
    int32_t face;
    std::array<int32_t, 3> vertex;
    std::array<Vec, 3> x;

    Vec middle() const { return (1.0 / 3) * (x[0] + x[1] + x[2]); }
    Vec area_vector() const { return cross(x[1] - x[0], x[2] - x[0]); }
};

class LostPlaces {
  public:
    void resize(int32_t faces) { first_.resize(faces, -1); }
    // Adds the places of a face to a list.
    void gather(int32_t face, std::vector<Vec>& places) const;
    void forget(int32_t face);
    // Gives each place to the face nearest to it, if it is farther away than `least`.
    void assign(const std::vector<Vec>& places, const std::vector<FaceShape>& faces, double least);

  private:
    struct Place {
        Vec point;
        double distance;
        int32_t next;
    };
    void add(int32_t face, const Vec& point, double distance);

    std::vector<int32_t> first_;  // of each face, or -1
    std::vector<Place> pool_;
    int32_t free_ = -1;
};

// Whether none of the places is farther than `most` from all the faces.
bool are_near(const std::vector<Vec>& places, const std::vector<FaceShape>& faces, double most);

}  // namespace henkei
