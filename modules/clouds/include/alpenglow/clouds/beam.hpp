// Tables of the light that a directional source, seen through its optical depth, sends towards the eye.
#pragma once

#include <array>
#include <vector>

#include <alpenglow/clouds/phase.hpp>

namespace alpenglow::clouds {

// Delta-M scaling (Wiscombe 1977) with moments up to l = 3: the fraction f = chi_4 of the phase function is taken as
// going straight on. Phase functions that a forward peak does not describe (chi_4 < 0, or scaled moments beyond +-1)
// get f = 0.
struct ScaledMedium {
    double forward = 0.0;                      // f
    double extinction = 1.0;                   // 1 - albedo f: scaled extinction over extinction
    double albedo = 1.0;                       // albedo (1 - f) / (1 - albedo f)
    std::array<double, 4> moments{1, 0, 0, 0}; // (chi_l - f) / (1 - f)
};
[[nodiscard]] ScaledMedium scaled_medium(const Medium& medium);

// Light scattered towards the eye by a unit of optical depth, for a unit of irradiance, as a function of the depth
// towards the light and of the angle between the light's and the eye ray's directions of travel. exp(-decay * depth) is
// taken out of what is stored. Interpolated linearly in sqrt(depth) and asinh(angle / narrow).
class BeamTable {
public:
    static constexpr int depths = 128;
    static constexpr int angles = 128;

    // value(depth, one_minus_cos) per steradian.
    [[nodiscard]] float value(float depth, float one_minus_cos) const;

    // albedo * phase * exp(-depth): the classic.
    static BeamTable single_scattering(const Medium& medium);
    // Wrenninge's octaves: sum over i of scatter^i * albedo * phase(g * phase^i) * exp(-extinction^i * depth); his
    // energy rule is scatter <= extinction. (Wrenninge, Kulla & Lundqvist 2013)
    struct Octaves {
        int count = 8;
        float scatter = 0.5F;
        float extinction = 0.5F;
        float phase = 0.5F;
    };
    static BeamTable octaves(const Medium& medium, const Octaves& octaves);
    // The beam with its own small-angle multiple scattering, for scaled extinction along the eye ray.
    //
    // Split the phase function as p = p_smooth + R with p_smooth = (1 - f) * (moments up to l = 3). The light that R
    // alone scatters goes straight but broadens: with the Legendre moments R_l = f (l <= 3) and chi_l (l > 3), radiance
    // at depth tau has the moments B_l = exp(-(1 - albedo R_l) tau) (Goudsmit & Saunderson 1940). The eye integrates
    // with the scaled extinction, exactly if its source is S - albedo f sigma I: per unit optical depth albedo * sum
    // over l of (2l+1)/(4 pi) (chi_l - f) B_l P_l(cos), less its limit for large l, which is the sun's own disc.
    static BeamTable broadened(const Medium& medium);
    // Any function: for Harris, whose light comes as a depth field of its own.
    static BeamTable product(double decay, double max_depth, double narrow, const std::vector<double>& of_depth,
                             const std::vector<double>& of_angle);

    [[nodiscard]] float decay() const { return decay_; }
    [[nodiscard]] float max_depth() const { return max_depth_; }
    [[nodiscard]] float narrow() const { return narrow_; }
    [[nodiscard]] const std::vector<float>& values() const { return values_; } // [angle][depth]
    // Where an angle or depth lies in the table, 0 .. angles - 1 or depths - 1.
    [[nodiscard]] float angle_coordinate(float one_minus_cos) const { return angle_coordinate(one_minus_cos, narrow_); }
    [[nodiscard]] static float angle_coordinate(float one_minus_cos, float narrow);
    [[nodiscard]] static double depth_at(int i, double max_depth);
    [[nodiscard]] static double angle_at(int i, double narrow);

private:
    void resize(double decay, double max_depth, double narrow);
    float decay_ = 1.0F;
    float max_depth_ = 64.0F;
    float narrow_ = 0.1F;
    std::vector<float> values_;
};

} // namespace alpenglow::clouds
