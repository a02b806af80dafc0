// The whole landscape: terrain, objects, and what is kept up to date as camera and sun move.
#pragma once

#include "object_meshes.hpp"
#include "object_shadows.hpp"
#include "render_data.hpp"
#include "terrain.hpp"
#include "terrain_lod.hpp"

#include <memory>
#include <vector>

namespace alpenglow::sandbox {

struct World {
    Terrain terrain;
    WorldData data;
    std::vector<ObjectMesh> object_kinds; // by ObjectKind
    std::unique_ptr<TerrainLod> lod;
    std::unique_ptr<ObjectShadows> shadows;
};

inline constexpr std::uint32_t default_seed = 1;

// Generates everything; deterministic. A World refers to itself, hence the pointer.
[[nodiscard]] std::unique_ptr<World> build_world(std::uint32_t seed = default_seed);

// What follows cheaply, into a world that has its terrain, the terrain's vertices and its level of detail: grids,
// default triangles, objects and their shadows.
void furnish(World& world);

// Places huts, chapel, barns, groups of conifers and boulders near the places that scenes look at; sorted by mesh.
[[nodiscard]] std::vector<ObjectInstance> place_objects(const Terrain& terrain, const MeshData& terrain_mesh,
                                                        const std::vector<ObjectMesh>& meshes);

} // namespace alpenglow::sandbox
