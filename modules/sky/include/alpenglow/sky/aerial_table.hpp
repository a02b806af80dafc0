// Aerial perspective of the scattering atmosphere as a table: what the air adds and takes between a viewer and things
// up to some distance, for one height of the viewer and one sun. shaders/alpenglow/sky_view.glsl reads it with the same
// code that is compiled here.
#pragma once

#include <alpenglow/sky/aerial_perspective.hpp>
#include <alpenglow/sky/scattering_tables.hpp>

#include <span>
#include <vector>

#include <glm/vec3.hpp>

namespace alpenglow::sky {

// Cosines to the zenith by a signed square law around the level, azimuths from the sun 0 .. pi, distances by a square
// law. Means along the way are stored (light added per km, extinction), so that short distances lose nothing.
class AerialTable {
public:
    explicit AerialTable(int rows = 32, int columns = 32, int slices = 32, float reach_km = 100.0F)
        : rows_(rows), columns_(columns), slices_(slices), reach_km_(reach_km) {}

    void build(const ScatteringTables& tables, float height_km, float mu_s);

    // Transmittance and light added (cd/m^2) over distance_km (held to the reach) towards a unit direction. The share
    // of the aerosol's scattering that goes straight on counts as transmitted (docs/sky.md).
    [[nodiscard]] AerialPerspective evaluate(const glm::vec3& direction, float distance_km,
                                             const glm::vec3& to_sun) const;

    [[nodiscard]] int rows() const { return rows_; }
    [[nodiscard]] int columns() const { return columns_; }
    [[nodiscard]] int slices() const { return slices_; }
    [[nodiscard]] float reach_km() const { return reach_km_; }
    [[nodiscard]] float mie_g() const { return mie_g_; }
    [[nodiscard]] float mie_mean_cosine() const { return mie_mean_cosine_; }
    // [slice][row][term][column] RGB: light added per km by molecules, aerosol, aureole (these without their phase
    // functions, as in SkyView), multiple scattering; cd/m^2 per km.
    [[nodiscard]] std::span<const glm::vec3> light() const { return light_; }
    // [slice][row] mean extinction per km.
    [[nodiscard]] std::span<const glm::vec3> extinction() const { return extinction_; }

private:
    int rows_, columns_, slices_;
    float reach_km_;
    float mie_g_ = 0.8F, mie_mean_cosine_ = 0.84F;
    std::vector<glm::vec3> light_, extinction_;
};

} // namespace alpenglow::sky
