/// The runtime once more, without SIMD and under other names.
#define RSV_RT_SCALAR
#define rsv_rt_status_text scalar_status_text
#define rsv_rt_relight scalar_relight
#define rsv_rt_turn scalar_turn
#define rsv_rt_operator_check scalar_operator_check
#define rsv_rt_solver_begin scalar_solver_begin
#define rsv_rt_solver_keep_bounced scalar_solver_keep_bounced
#define rsv_rt_solver_update scalar_solver_update
#define rsv_rt_solver_update_while scalar_solver_update_while
#define rsv_rt_receivers_check scalar_receivers_check
#define rsv_rt_receive scalar_receive
#define rsv_rt_probe_at scalar_probe_at
#define rsv_rt_sh_irradiance scalar_sh_irradiance
#include "resolvent_rt.c"
