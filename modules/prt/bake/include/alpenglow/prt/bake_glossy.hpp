// Bakes glossy transfer matrices: Sloan, Kautz and Snyder (2002), sections 4.2 and 5.
#pragma once

#include <alpenglow/prt/bake.hpp>
#include <alpenglow/prt/field_part.hpp>

namespace alpenglow::prt {

struct GlossySettings {
    Transport transport = Transport::shadowed;
    int order = 5;                 // bands of the light (columns)
    int out_order = 5;             // bands of transferred radiance (rows): more for sharper lobes, 2 .. 6
    std::size_t rays = 4096;       // over the sphere, about half are shot
    std::size_t gather_rays = 512; // over the sphere, for bounces
    int max_bounces = 3;
    double stop_energy = 1e-3;
    // How the object itself reflects, for bounces: diffuse by its albedo, and a lobe.
    float default_albedo = 0.5F;
    float specular = 0.0F; // part of the light that the lobe reflects, 0 .. 1
    float phong_exponent = 16.0F;
    std::uint64_t seed = 1;
    unsigned threads = 0;
    ProgressCallback progress;
};

// One matrix a vertex: light coefficients -> coefficients of the radiance that arrives at the vertex from its upper
// hemisphere (M^GS, eq. 11, and its bounces); below the horizon the surface itself is in the way.
[[nodiscard]] Result<Bake> bake_glossy(const Mesh& mesh, const GlossySettings& settings);

// The same in parts. Bounces need all vertices: `finish_glossy` traces them.
[[nodiscard]] Result<FieldPart> bake_glossy_part(const Mesh& mesh, const GlossySettings& settings, std::size_t first,
                                                 std::size_t count);
[[nodiscard]] Result<Bake> finish_glossy(const Mesh& mesh, const GlossySettings& settings,
                                         std::vector<FieldPart> parts);

} // namespace alpenglow::prt
