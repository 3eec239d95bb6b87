// Isotropic remeshing; the method is described in remeshing.cpp.
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "feature_curves.hpp"
#include "lost_places.hpp"
#include "reference_surface.hpp"
#include "triangle_edits.hpp"

namespace henkei {

class Remeshing {
  public:
    explicit Remeshing(const RemeshingInput& input);

    // Whether no more than `most` faces came of it; ends at once where there are more.
    bool split_long(int64_t most);
    void collapse_short();
    void flip();
    void relax();
    // Splits the edges that join two vertices of features without being features, and the faces
    // with three feature edges. From then on no flip brings such an edge back.
    void separate();

    struct Result {
        std::vector<double> weights;
        std::vector<int32_t> faces, on_face;
        std::vector<uint8_t> feature, corner;
    };
    Result result() const;

  private:
    // Of a face: the face of the input nearest to its middle, how far that is, and its normal.
    struct Fit {
        int32_t face;
        double gap;
        Vec normal;
    };
    struct Quality {
        double shape;    // from 0, a sliver, to 1, equilateral
        double upright;  // cosine between its normal and the input's
    };
    struct Worst {
        double shape = 1, upright = 1, gap = 0;
        int turned = 0;
    };
    static constexpr double kTolerance = 0.1;  // of the wished length, off the surface
    static constexpr double kUpright = 0.26;   // cosine of the angle by which a face may lean
    static constexpr int32_t kMostDegree = 100, kCheckEvery = 4096;

    // Half-edges in the order of a key, equal ones by number.
    using Ranked = std::vector<std::pair<double, int32_t>>;

    const Vec& point(int32_t v) const { return place_[v].point; }
    double wished(int32_t v, int32_t w) const { return 0.5 * (length_[v] + length_[w]); }
    double edge_length(int32_t h) const;
    // Of an edge, by what is wished.
    double relative_length(int32_t h) const;
    bool is_feature(int32_t v) const { return kind_[v] != FeatureKind::kSmooth; }
    FaceShape shape_of(int32_t f) const;
    Quality quality(const FaceShape& face, const Vec& normal) const;
    bool is_turned(const FaceShape& face) const;
    Fit fit(const FaceShape& face, int32_t start);
    void add_to(Worst& worst, const FaceShape& face) const;
    bool fits(const std::vector<FaceShape>& after, Worst before, double tolerance);
    void add_vertex(const SurfacePlace& place, FeatureKind kind);
    void add_face(int32_t f, int32_t like);
    void split_middle(int32_t f);
    void replace(const std::vector<int32_t>& before, const std::vector<Vec>& lost,
                 const std::vector<FaceShape>& after, double tolerance);

    bool split_longer(double than, int64_t most);
    bool shortens(int32_t h, const Vec& middle) const;
    bool keeps_upright(int32_t h, const Vec& middle) const;
    void split(int32_t h, const SurfacePlace& middle);
    SurfacePlace middle_of(int32_t h);
    bool try_collapse(int32_t h, int32_t gone);
    bool makes_long(int32_t gone, int32_t kept) const;
    struct JoinedLine {
        int32_t end = -1;  // the neighbour to which the line now goes
        Line line;         // from the vertex that is kept
    };
    JoinedLine joined_line(int32_t h, int32_t gone, int32_t kept) const;
    bool try_flip(int32_t h);
    int regularity_gain(int32_t a, int32_t b, int32_t c, int32_t d) const;

    Vec centre(int32_t v) const;
    void move(int32_t v);
    void slide(int32_t v);
    bool move_to(int32_t v, const SurfacePlace& place);
    void refit();

    ReferenceSurface surface_;
    FeatureCurves curves_;
    TriangleEdits mesh_;
    std::vector<SurfacePlace> place_;  // of each vertex
    std::vector<double> length_;
    std::vector<FeatureKind> kind_;
    std::vector<Fit> fit_;  // of each face
    LostPlaces lost_;
    bool separated_ = false, graded_ = false;

    // Of the change in question: the faces before and after, how these fit, and lost places.
    std::vector<int32_t> before_;
    std::vector<FaceShape> after_;
    std::vector<Fit> fits_;
    std::vector<Vec> places_;
};

}  // namespace henkei
