#include "sandbox/app/transfer_objects.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <alpenglow/prt/import_mesh.hpp>
#include <alpenglow/prt/shapes.hpp>

#include "sandbox/app/transfer_light.hpp"
#include "sandbox/app/transfer_shapes.hpp"
#include "sandbox/app/transfer_smoke.hpp"
#include "sandbox/world/noise.hpp"
#include "sandbox/world/vertex.hpp"

namespace alpenglow::sandbox {
namespace {

constexpr glm::vec2 place_m(348.0F, -100.0F); // level to some centimetres, north of the hamlet
constexpr float mound_half_m = 10.0F;
constexpr glm::vec2 mound_m(0.3F, 12.5F); // from the place
constexpr float disc_thickness_m = 0.16F;
constexpr glm::vec3 pale(0.22F, 0.195F, 0.16F); // rims of slabs

prt::BakeSettings bake_settings() {
    prt::BakeSettings settings;
    settings.order = transfer_bands;
    settings.rays = 1024;
    settings.max_error = 1e-2;
    settings.gather_rays = 192;
    settings.max_bounces = 6;
    settings.stop_energy = 3e-3;
    settings.colour = true;
    return settings;
}

// A body on a round slab, as one mesh.
prt::Mesh on_disc(prt::Mesh body, const prt::Mesh& disc) {
    return prt::merged(std::move(body), disc);
}

auto two_rings(const glm::vec3& inner, const glm::vec3& outer, float at_m) {
    return
        [=](float radius_m) { return glm::mix(inner, outer, glm::smoothstep(at_m - 0.04F, at_m + 0.04F, radius_m)); };
}

float bumps(const glm::vec2& p) { // from the mound's middle
    const glm::vec2 q = p / mound_half_m;
    const auto hill = [&](float x, float y, float width, float height) {
        const glm::vec2 d = (q - glm::vec2(x, y)) / width;
        return height * std::exp(-glm::dot(d, d));
    };
    const float swell = hill(-0.45F, 0.05F, 0.22F, 1.5F) + hill(0.35F, -0.25F, 0.18F, 1.1F) +
                        hill(0.2F, 0.45F, 0.3F, 1.9F) + hill(-0.1F, -0.5F, 0.15F, 0.7F) +
                        hill(0.68F, 0.15F, 0.16F, 0.9F) + hill(-0.6F, 0.6F, 0.2F, 1.2F);
    const float rough = 0.22F * fractal_noise(0.45F * p.x, 0.45F * p.y, 3, 77U);
    const float r = std::max(std::abs(q.x), std::abs(q.y));
    const float edge = 1.0F - glm::smoothstep(0.72F, 1.0F, r);
    return edge * (swell + rough + 0.1F) - 0.12F * (1.0F - edge);
}

// Reflectance of the meadow near the place, from the terrain's vertices.
glm::vec3 meadow(const World& world, glm::vec2 at_m) {
    if (world.data.terrain_grids.empty()) {
        return {0.1F, 0.14F, 0.05F};
    }
    const TerrainGrid& grid = world.data.terrain_grids.back();
    const glm::ivec2 last(static_cast<int>(grid.samples) - 1);
    const glm::ivec2 cell =
        glm::clamp(glm::ivec2(glm::round((at_m - grid.origin_m) / grid.spacing_m)), glm::ivec2(0), last);
    const std::size_t vertex = grid.first_vertex + static_cast<std::size_t>(cell.x) +
                               std::size_t{grid.samples} * static_cast<std::size_t>(cell.y);
    return unpack_albedo(world.data.terrain.vertices[vertex].albedo);
}

// A mesh from a file, as tall as the figure, on z = 0.
Result<prt::Mesh> imported(const std::string& path) {
    Result<prt::Mesh> mesh = prt::import_mesh(path);
    if (!mesh) {
        return mesh;
    }
    const prt::Bounds box = prt::bounds(*mesh);
    const glm::vec3 size = box.high - box.low;
    const float scale = 2.4F / std::max({size.x, size.y, size.z, 1e-6F});
    const glm::vec3 foot(0.5F * (box.low.x + box.high.x), 0.5F * (box.low.y + box.high.y), box.low.z);
    for (glm::vec3& p : mesh->positions) {
        p = (p - foot) * scale;
    }
    if (mesh->normals.empty()) {
        prt::compute_normals(*mesh);
    }
    if (mesh->albedo.empty()) {
        paint(*mesh, glm::vec3(0.6F));
    }
    return mesh;
}

prt::GlossySettings gloss_of(float specular, double phong_exponent) {
    prt::GlossySettings gloss;
    gloss.order = transfer_bands;
    gloss.out_order = transfer_bands;
    gloss.rays = 1024;
    gloss.gather_rays = 192;
    gloss.max_bounces = 2;
    gloss.default_albedo = 0.1F;
    gloss.specular = specular;
    gloss.phong_exponent = static_cast<float>(phong_exponent);
    return gloss;
}

} // namespace

TransferObjects make_transfer_objects(const World& world, const TransferSettings& settings) {
    TransferObjects objects;
    objects.middle_m = glm::vec3(place_m, world.terrain.height_m(place_m));
    objects.radius_m = 32.0F;
    const float fine = std::sqrt(settings.detail); // edges along one direction
    const auto n = [&](int edges) {
        return std::max(6, static_cast<int>(std::lround(static_cast<float>(edges) * fine)));
    };
    const auto stand = [&](glm::vec2 from_middle_m) {
        const glm::vec2 at = place_m + from_middle_m;
        return glm::vec3(at, world.terrain.height_m(at) + disc_thickness_m - 0.03F);
    };
    const prt::BakeSettings settings_of_all = bake_settings();

    { // A figure of marble on warm stone: folds, bounces, a colour that bleeds.
        TransferObject figure;
        figure.name = "figure";
        figure.position_m = stand({-2.1F, 0.7F});
        prt::Mesh body;
        if (!settings.mesh.empty()) {
            Result<prt::Mesh> mesh = imported(settings.mesh);
            if (mesh) {
                body = std::move(mesh).value();
            } else {
                objects.problem = mesh.error().message();
            }
        }
        if (body.positions.empty()) {
            body = make_figure(0.03F / fine);
        }
        figure.mesh = on_disc(std::move(body), make_disc(1.75F, disc_thickness_m, n(72), n(24),
                                                         two_rings({0.30F, 0.085F, 0.04F}, pale, 1.35F)));
        figure.diffuse = diffuse_job(figure.name, figure.mesh, settings_of_all);
        objects.bodies.push_back(std::move(figure));
    }
    { // A knot of polished bronze. The slab that its gloss mirrors is a coarse one.
        TransferObject knot;
        knot.name = "glossy knot";
        knot.position_m = stand({1.75F, 0.35F});
        const prt::Mesh body = make_knot(0.72F, 0.17F, n(150), n(18), {0.10F, 0.055F, 0.025F});
        knot.glossy_vertices = body.positions.size();
        const auto stone = two_rings({0.13F, 0.15F, 0.17F}, pale, 1.0F);
        knot.mesh = on_disc(body, make_disc(1.35F, disc_thickness_m, n(64), n(22), stone));
        knot.specular = {0.78F, 0.55F, 0.33F};
        knot.phong_exponent = 40.0;
        knot.diffuse = diffuse_job("knot", knot.mesh, settings_of_all);
        knot.glossy = glossy_job(knot.name, on_disc(body, make_disc(1.35F, disc_thickness_m, 16, 5, stone)),
                                 gloss_of(0.5F, knot.phong_exponent));
        objects.bodies.push_back(std::move(knot));
    }
    { // A ring of gold that lies on white stone: its inside throws a caustic. The plate and the ring are two bodies,
      // since mirrors carry no diffuse transfer; what the ring shows comes from a matrix.
        const glm::vec3 at = stand({-0.15F, -1.75F});
        const glm::vec3 gold(0.9F, 0.68F, 0.3F);
        prt::Mesh ring = make_ring(0.62F, 0.66F, 0.34F, n(120), n(5), gold);
        const auto white = two_rings({0.27F, 0.255F, 0.23F}, {0.17F, 0.15F, 0.125F}, 1.3F);
        TransferObject plate;
        plate.name = "ring and caustic";
        plate.position_m = at;
        plate.mesh = make_disc(1.45F, disc_thickness_m, n(96), n(40), white);
        const std::size_t own = plate.mesh.triangles.size();
        prt::Mesh both = prt::merged(plate.mesh, ring);
        both.mirror.assign(both.triangles.size(), 0);
        std::fill(both.mirror.begin() + static_cast<std::ptrdiff_t>(own), both.mirror.end(), std::uint8_t{1});
        prt::BakeSettings caustic = settings_of_all;
        caustic.rays = 2048;
        plate.diffuse = diffuse_job(plate.name, both, caustic);
        objects.bodies.push_back(std::move(plate));
        TransferObject band;
        band.name = "ring";
        band.position_m = at;
        band.mesh = ring;
        band.glossy_vertices = ring.positions.size();
        band.specular = gold;
        band.phong_exponent = 60.0;
        band.glossy = glossy_job("ring's gloss", on_disc(ring, make_disc(1.45F, disc_thickness_m, 16, 5, white)),
                                 gloss_of(0.6F, band.phong_exponent));
        objects.bodies.push_back(std::move(band));
    }
    { // Where the smoke rises.
        TransferObject brazier;
        brazier.name = "brazier";
        brazier.position_m = stand({3.9F, 1.5F});
        brazier.mesh =
            on_disc(make_brazier(n(28), {0.12F, 0.11F, 0.11F}),
                    make_disc(1.0F, disc_thickness_m, n(48), n(14), two_rings({0.15F, 0.13F, 0.11F}, pale, 0.7F)));
        brazier.diffuse = diffuse_job(brazier.name, brazier.mesh, settings_of_all);
        objects.smoke_position_m = brazier.position_m + glm::vec3(0.0F, 0.0F, 0.56F);
        objects.bodies.push_back(std::move(brazier));
        objects.smoke_density = make_plume(0.14F / std::cbrt(settings.detail));
        prt::VolumeSettings volume;
        volume.order = transfer_bands;
        volume.directions = 64;
        volume.albedo = smoke_albedo;
        volume.max_bounces = 6;
        volume.stop_energy = 1e-2;
        objects.smoke = volume_job("smoke", objects.smoke_density, volume);
    }
    { // Bumpy ground under the glider, its rim sunk into the meadow.
        TransferObject mound;
        mound.name = "ground";
        const glm::vec2 middle = place_m + mound_m;
        const float base_m = world.terrain.height_m(middle);
        mound.position_m = glm::vec3(middle, base_m);
        mound.mesh = prt::heightfield(mound_half_m, n(76), [&](float x, float y) {
            return world.terrain.height_m(middle + glm::vec2(x, y)) - base_m + bumps({x, y});
        });
        for (const glm::vec3& p : mound.mesh.positions) {
            const float tone = 1.0F + 0.25F * fractal_noise(0.8F * p.x, 0.8F * p.y, 3, 31U);
            mound.mesh.albedo.push_back(glm::clamp(meadow(world, middle + glm::vec2(p)) * tone, 0.0F, 1.0F));
        }
        prt::BakeSettings ground = settings_of_all;
        ground.gather_rays = 96;
        mound.diffuse = diffuse_job(mound.name, mound.mesh, ground);
        objects.mound = objects.bodies.size();
        objects.bodies.push_back(std::move(mound));
    }
    { // A glider, and what it does to the light around.
        TransferObject glider;
        glider.name = "glider";
        const prt::Mesh mesh = make_glider(3.3F, n(10));
        glider.mesh = mesh;
        glider.diffuse = diffuse_job(glider.name, mesh, settings_of_all);
        prt::NeighbourhoodSettings around;
        around.order = transfer_bands;
        around.out_order = 3;
        around.rays = 768;
        const prt::Grid grid = prt::grid_around(mesh, glm::uvec3(17, 17, 9), 0.9F, 0.2F, 1.3F);
        objects.around_glider = neighbourhood_job("glider's shadow", mesh, grid, around);
        objects.glider = objects.bodies.size();
        objects.bodies.push_back(std::move(glider));
    }
    return objects;
}

} // namespace alpenglow::sandbox
