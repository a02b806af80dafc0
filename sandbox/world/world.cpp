#include "world.hpp"

#include "terrain_mesh.hpp"

namespace alpenglow::sandbox {

std::unique_ptr<World> build_world(std::uint32_t seed) {
    auto world = std::make_unique<World>();
    Terrain& terrain = world->terrain;
    terrain = generate_terrain(seed);
    world->data.terrain = make_terrain_mesh(terrain);
    terrain.inner_area_m2 = {};
    terrain.outer_area_m2 = {};
    world->lod = std::make_unique<TerrainLod>(terrain, world->data.terrain.vertices);
    furnish(*world);
    return world;
}

void furnish(World& world) {
    std::uint32_t first_vertex = 0;
    for (const HeightGrid* grid : {&world.terrain.outer, &world.terrain.inner}) {
        world.data.terrain_grids.push_back(
            {first_vertex, static_cast<std::uint32_t>(grid->n), grid->spacing_m, grid->origin_m});
        first_vertex += static_cast<std::uint32_t>(grid->n * grid->n);
    }
    world.data.terrain.indices = world.lod->coarse_indices(60.0F);
    for (std::uint32_t k = 0; k < object_kinds; ++k) {
        world.object_kinds.push_back(make_object_mesh(static_cast<ObjectKind>(k)));
        world.data.object_meshes.push_back(world.object_kinds.back().mesh);
    }
    world.data.objects = place_objects(world.terrain, world.data.terrain, world.object_kinds);
    world.shadows = std::make_unique<ObjectShadows>(world.object_kinds, world.data.objects);
}

} // namespace alpenglow::sandbox
