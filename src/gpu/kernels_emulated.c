/// Kernels for the emulated device.
#define RSV_KERNELS_HERE
#include "basis_kernels.h"
#include "bicgstab_kernels.h"
#include "chebyshev_kernels.h"
#include "compact_kernels.h"
#include "diffusion_kernels.h"
#include "direct_kernels.h"
#include "frame_kernels.h"
#include "occlusion_kernels.h"
#include "row_kernels.h"
#include "shooting_kernels.h"
#include "solver_kernels.h"
#include "transport_kernels.h"
