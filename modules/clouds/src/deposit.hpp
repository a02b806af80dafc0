// What a beam loses along a row of voxels. Internal to the module.
#pragma once

namespace alpenglow::clouds {

// out = extinction * density times the beam at voxel centres, averaged along the light over a slab of `thickness`
// metres: e^-depth sinh(h) / h with h half the slab's own depth.
void deposit_row(const float* density, const float* depth, float extinction, float thickness, float* out, int count);

} // namespace alpenglow::clouds
