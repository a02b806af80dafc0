// The light inside a cloud, by one of four methods behind one interface.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include <alpenglow/clouds/beam.hpp>
#include <alpenglow/clouds/bricks.hpp>
#include <alpenglow/clouds/optical_depth.hpp>
#include <alpenglow/clouds/phase.hpp>
#include <alpenglow/clouds/view.hpp>

namespace alpenglow::clouds {

enum class LightingMethod {
    single_scattering, // light that is scattered once
    harris,            // multiple forward scattering: course notes, cloud rendering, eq. 7 to 9
    octaves,           // Wrenninge, Kulla & Lundqvist 2013
    transport          // discrete ordinates after a broadened beam: docs/clouds.md
};

struct LightingSettings {
    LightingMethod method = LightingMethod::transport;
    int depth_factor = 1;                                   // voxels a side of the optical depth's blocks
    int transport_factor = 2;                               // and of the multiply scattered light's, at least
    int sweeps = 6;                                         // of the ordinates, from a cold start
    int warm_sweeps = 1;                                    // and after a light has turned a little
    std::size_t max_depth_cells = std::size_t(6) << 20;     // beyond, blocks grow
    std::size_t max_transport_cells = std::size_t(1) << 17; // a fifth of a second of CPU time for sun and sky
    BeamTable::Octaves octaves;
    Phase harris_phase{PhaseKind::rayleigh, 0.0F, 0.0F, 1.0F}; // what the paper draws with
    bool harris_saturate = false;
};

// One directional light's state.
struct BakedLight {
    glm::vec3 to_light{0, 0, 1}; // the grid's frame
    glm::vec3 irradiance{0.0F};
    Field16 depth;              // optical depth towards the light (Harris: -log of what arrives)
    std::vector<float> moments; // of the multiply scattered radiance, a unit of irradiance; 16 an active cell
};

struct BakeStats {
    double depth_s = 0.0; // CPU time of this thread and its helpers
    double transport_s = 0.0;
    float residual = 0.0F; // relative change of the scalar flux in the last sweep
};

class Transport;

class CloudLighting {
public:
    CloudLighting();
    ~CloudLighting();
    CloudLighting(CloudLighting&&) noexcept;
    CloudLighting& operator=(CloudLighting&&) noexcept;

    // Binds to a volume (kept by the caller) and forgets what was baked.
    void reset(const BrickVolume& volume, const Medium& medium, const LightingSettings& settings);

    // Bakes light i anew; from the light's last state if there is one and `warm`.
    BakeStats bake_light(std::size_t i, const DirectionalLight& light, bool warm = true);

    // The same, spread out. start_* does what a frame needs at once (the optical depth, so that shadows follow the
    // light) and queues the multiply scattered part; until that is done, the last state's serves. Starting what is
    // queued already replaces it. advance() does one bounded slice of the queue and returns whether there was any.
    BakeStats start_light(std::size_t i, const DirectionalLight& light, bool warm = true);
    void start_sky(const SkySh& sky, bool warm = true);
    bool advance();
    // Does the rest of the queue at once, jobs side by side: several lights and the sky started, then finished, take
    // less time on two threads than one bake after the other. The bits are the same.
    BakeStats finish();
    [[nodiscard]] bool working() const;
    [[nodiscard]] bool working_on_light(std::size_t i) const;
    [[nodiscard]] bool working_on_sky() const;
    void remove_lights(std::size_t keep); // all but the first `keep`
    // A change of colour or strength alone costs nothing.
    void set_irradiance(std::size_t i, const glm::vec3& irradiance) { lights_[i].irradiance = irradiance; }
    BakeStats bake_sky(const SkySh& sky, bool warm = true);

    [[nodiscard]] const std::vector<BakedLight>& lights() const { return lights_; }
    [[nodiscard]] const BeamTable& table() const { return *table_; }
    [[nodiscard]] const Medium& medium() const { return medium_; }
    [[nodiscard]] const LightingSettings& settings() const { return settings_; }
    // Extinction along eye rays over the medium's.
    [[nodiscard]] float eye_extinction() const { return eye_extinction_; }

    // Multiply scattered light and skylight, per unit of (eye) optical depth, towards an eye at index coordinates
    // `eye`: one field if all light has one colour (times `colour`), else three.
    struct ViewFields {
        std::vector<Field16> fields;
        glm::vec3 colour{1.0F};
    };
    [[nodiscard]] ViewFields contract(const glm::dvec3& eye) const;

    // The same for any eye: the mean over directions of what is scattered, for uses that can spare the directions.
    [[nodiscard]] ViewFields contract_mean() const;

    // Mean radiance from all directions at index coordinates (multiply scattered and sky light, without direct
    // sunlight).
    [[nodiscard]] glm::vec3 mean_radiance(const glm::vec3& index) const;

    [[nodiscard]] std::size_t memory_bytes() const;

private:
    [[nodiscard]] ViewFields contract(const glm::dvec3* eye) const;
    struct Jobs;
    void bake_sky_directly(const SkySh& sky);
    const BrickVolume* volume_ = nullptr;
    Medium medium_;
    LightingSettings settings_;
    float eye_extinction_ = 1.0F;
    std::shared_ptr<const BeamTable> table_;
    std::array<float, 4> view_weights_{}; // albedo * phase moment, for what the moments send towards the eye
    Lattice depth_lattice_;
    std::vector<float> depth_density_; // block means, kept between bakes
    std::unique_ptr<Transport> transport_;
    std::unique_ptr<Jobs> jobs_;
    std::vector<BakedLight> lights_;
    std::vector<std::vector<float>> sky_; // moments; 1 or 3
    glm::vec3 sky_colour_{1.0F};          // of the single one
};

} // namespace alpenglow::clouds
