// Bakes what an object does to the light around it, for shadows on receivers that nobody knew at the bake: Sloan, Kautz
// and Snyder (2002), section 8.
#pragma once

#include <alpenglow/prt/bake.hpp>
#include <alpenglow/prt/field_part.hpp>

namespace alpenglow::prt {

struct NeighbourhoodSettings {
    int order = 5;           // bands of the light
    int out_order = 3;       // bands of the light that arrives: 3 for diffuse receivers (the paper's 9 x 25)
    std::size_t rays = 2048; // a grid point, over the sphere
    bool bounce = false;     // the object also sends light on: its own interreflected bake, and default_albedo
    float default_albedo = 0.5F;
    std::uint64_t seed = 1;
    unsigned threads = 0;
    ProgressCallback progress;
};

// One matrix a grid point, in the object's frame: M_ij = int V y_i y_j (and what bounces off the object). Points inside
// the object take the mean of their neighbours, so that interpolation near its surface stays sound; the report counts
// them as inside.
[[nodiscard]] Result<Bake> bake_neighbourhood(const Mesh& mesh, const Grid& grid,
                                              const NeighbourhoodSettings& settings);

// The same in parts. With `bounce`, each part bakes the object's own surface.
[[nodiscard]] Result<FieldPart> bake_neighbourhood_part(const Mesh& mesh, const Grid& grid,
                                                        const NeighbourhoodSettings& settings, std::size_t first,
                                                        std::size_t count);
[[nodiscard]] Result<Bake> finish_neighbourhood(const Mesh& mesh, const Grid& grid,
                                                const NeighbourhoodSettings& settings, std::vector<FieldPart> parts);

// A grid of `size` points around the mesh: `beside` and `above` times its half width on the sides and above, and
// `below` below, where shadows fall.
[[nodiscard]] Grid grid_around(const Mesh& mesh, const glm::uvec3& size, float beside, float above, float below);

} // namespace alpenglow::prt
