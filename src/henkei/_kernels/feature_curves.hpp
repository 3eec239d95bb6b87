// The feature edges of a surface as curves from corner to corner, measured by arc length.
#pragma once

#include <cstdint>
#include <vector>

#include "reference_surface.hpp"
#include "triangle_edits.hpp"

namespace henkei {

enum class FeatureKind : uint8_t { kSmooth, kLine, kCorner };

class FeatureCurves {
  public:
    explicit FeatureCurves(const RemeshingInput& input);

    // A corner: where other than two feature edges meet, or where the curve turns sharply, both
    // from edge to edge and seen from half a wished edge away.
    FeatureKind kind(int32_t vertex) const { return kind_[vertex]; }
    // Of a half-edge; both sides of an edge run the same curve.
    const Line& line(int32_t h) const { return line_[h]; }
    SurfacePlace at(int32_t curve, double s) const;
    // How far a part of a curve is from the straight line between its ends.
    double deviation(const Line& part) const;

  private:
    struct Node {
        int32_t vertex;
        double s;
    };
    struct Curve {
        size_t begin, end;  // nodes; the edge from each but the last to the next
        double length;
        bool closed;
    };
    struct Ahead {
        Vec point;
        bool ends;
    };
    // Feature edges that leave a vertex: twice a half-edge, and one more where it ends there.
    using Leaving = int32_t;
    int32_t from(Leaving e) const;
    int32_t to(Leaving e) const;
    const Vec& end(Leaving e) const { return x_[to(e)]; }
    Leaving onward(Leaving e) const;
    Ahead ahead(int32_t vertex, Leaving e, double reach) const;
    bool turns(int32_t vertex, double wished) const;
    bool near_corner(int32_t vertex, double reach) const;
    void trace(Leaving e, std::vector<uint8_t>& traced);
    double at_distance(const Curve& curve, double s, size_t& node) const;

    std::vector<Vec> x_;
    std::vector<int32_t> faces_;
    std::vector<FeatureKind> kind_;
    std::vector<int64_t> first_;
    std::vector<Leaving> leaving_;
    std::vector<Line> line_;
    std::vector<Curve> curves_;
    std::vector<Node> nodes_;
    std::vector<Leaving> edges_;  // of each node the edge to the next
};

}  // namespace henkei
