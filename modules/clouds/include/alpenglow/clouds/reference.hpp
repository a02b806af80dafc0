// The truth that every method is held to: an unbiased volumetric path tracer.
//
// Free flight by delta tracking (Woodcock et al. 1965) over majorants of 4^3 voxels, light through ratio tracking
// (Novak, Selle & Jarosz 2014). Both read the trilinear density by picking one of the eight voxels with its weight,
// which leaves all expectations as they are. Shadow rays that promise little are dropped by Russian roulette, again
// without bias. Every sample of every pixel has its own random stream: pictures do not depend on the thread count, and
// samples can be split over machines and merged.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include <alpenglow/clouds/grid.hpp>
#include <alpenglow/clouds/phase.hpp>
#include <alpenglow/clouds/view.hpp>
#include <alpenglow/core/result.hpp>

namespace alpenglow::clouds {

// A Lambertian plane at z = height_m that light comes from below by.
struct Ground {
    bool present = false;
    double height_m = 0.0;
    glm::vec3 albedo{0.2F};
};

struct ReferenceScene {
    const SparseGrid* grid = nullptr;
    Medium medium;
    std::vector<DirectionalLight> lights;
    std::function<glm::vec3(const glm::vec3&)> sky; // radiance from a world direction; empty: black
    Ground ground;
    int max_scatterings = 0; // 0: as many as it takes
};

// Sums over samples. Seen: light scattered by the cloud, and sky and ground behind it; not the lights' own discs.
struct ReferenceImage {
    int width = 0;
    int height = 0;
    std::vector<glm::dvec3> sum[2];       // every other sample apart: two independent pictures
    std::uint64_t samples_of[2] = {0, 0}; // a pixel, of each
    std::vector<double> squares;          // of the samples' luminance

    ReferenceImage() = default;
    ReferenceImage(int w, int h);
    [[nodiscard]] std::uint64_t samples() const { return samples_of[0] + samples_of[1]; } // a pixel
    [[nodiscard]] glm::dvec3 mean(std::size_t pixel) const;
    [[nodiscard]] glm::dvec3 mean_of_half(int half, std::size_t pixel) const;
    [[nodiscard]] double standard_error(std::size_t pixel) const; // of the mean luminance
};

[[nodiscard]] inline double luminance(const glm::dvec3& c) {
    return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z;
}

class PathTracer {
public:
    explicit PathTracer(ReferenceScene scene);
    ~PathTracer();
    PathTracer(PathTracer&&) noexcept;
    PathTracer& operator=(PathTracer&&) noexcept;

    // Adds samples first, first + stride, ... (count of them) for every pixel.
    void render(const Camera& camera, ReferenceImage& image, std::uint64_t first, std::uint64_t count,
                std::uint64_t stride = 1, std::uint64_t seed = 1, unsigned threads = 0) const;

    // Radiance along one ray, averaged over samples: for tests of single rays.
    [[nodiscard]] glm::dvec3 radiance(const glm::dvec3& origin_m, const glm::vec3& direction, std::uint64_t samples,
                                      std::uint64_t seed = 1) const;
    // Transmittance between two points by ratio tracking, averaged over samples.
    [[nodiscard]] double transmittance(const glm::dvec3& from_m, const glm::vec3& direction, std::uint64_t samples,
                                       std::uint64_t seed = 1) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

// Pictures of two runs (shards) of one scene added up. Same size, or an error.
[[nodiscard]] Result<ReferenceImage> merge(const ReferenceImage& a, const ReferenceImage& b, const std::string& where);

// Sums on disk, with `note` (what scene it is) and the samples done; written beside and renamed, so that a stopped run
// leaves the last whole file.
struct ReferenceFile {
    ReferenceImage image;
    std::string note;
    std::uint64_t next_sample = 0; // where a resumed run goes on
};
[[nodiscard]] Status save_reference(const std::string& path, const ReferenceFile& file);
[[nodiscard]] Result<ReferenceFile> load_reference(const std::string& path);

// ||a - r|| / ||r|| over the pixels in `mask` (luminance), free of the reference's own noise: the square is the mean of
// (a - r1)(a - r2) over the independent halves, and so its expectation does not contain their variance. Bias: the ratio
// of means, minus 1.
struct ImageError {
    double relative_rmse = 0.0;
    double bias = 0.0;
    double noise = 0.0; // the reference's own relative standard error over the mask, for judging the two
};
[[nodiscard]] ImageError image_error(const std::vector<glm::vec3>& image, const ReferenceImage& reference,
                                     const std::vector<bool>& mask);

} // namespace alpenglow::clouds
