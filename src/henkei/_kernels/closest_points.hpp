// Points of a triangle mesh nearest to given points; the method is described in closest_points.cpp.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace henkei {

class ClosestPoints {
  public:
    // Keeps a copy; coordinates must be finite and small enough to be squared.
    ClosestPoints(const double* vertices, const int32_t* faces, int64_t face_count);

    // For each of `count` points (x, y, z): the face that holds the nearest point, its weights of
    // that face's corners, and the squared distance; -1, 0 and infinity where there is none.
    void query(const double* points, int64_t count, int32_t* face, double* barycentric,
               double* squared_distance) const;

  private:
    using Point = std::array<double, 3>;
    struct Triangle {
        Point corner[3];
        int32_t face;
        bool thin;          // its normal is not to be trusted
        bool backwards[3];  // whether side (i, i + 1) is measured from its end
    };
    struct Node {  // of the triangles [begin, end); its halves are the nodes left, left + 1
        Point low, high;
        int32_t begin, end, left;

        double squared_distance(const Point& p) const;
    };
    struct Nearest;

    static void compare(const Point& p, const Triangle& t, Nearest& nearest);
    void descend(const Point& p, Nearest& nearest) const;
    void split(const std::vector<std::array<float, 3>>& centres, std::vector<int32_t>& order);
    void enclose(double margin);

    std::vector<Triangle> triangles_;  // in the order of the leaves
    std::vector<Node> nodes_;
};

}  // namespace henkei
