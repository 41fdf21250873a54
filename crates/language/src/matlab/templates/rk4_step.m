function [state, residual] = scene_rk4_step(t, h, from, p)
    %SCENE_RK4_STEP One step of length `h` from time `t`.
    %
    %   The classical Runge-Kutta formula of order 4, then the projection of coordinates and rates onto the constraints in
    %   the mass metric. Accelerations and multipliers of the state are those of its own position.
    %
    %   `from` is a state as scene_state and scene_initial_state give it. `residual` is the largest residual of a
    %   constraint at the end. `p` holds the parameters: see scene_parameters.
    second = scene_state(t + h / 2, from.q + h / 2 * from.qd, from.qd + h / 2 * from.qdd, p);
    third = scene_state(t + h / 2, from.q + h / 2 * second.qd, from.qd + h / 2 * second.qdd, p);
    fourth = scene_state(t + h, from.q + h * third.qd, from.qd + h * third.qdd, p);
    q = from.q + h / 6 * (from.qd + 2 * (second.qd + third.qd) + fourth.qd);
    qd = from.qd + h / 6 * (from.qdd + 2 * (second.qdd + third.qdd) + fourth.qdd);
    [q, qd, residual] = project(t + h, q, qd, p);
    state = scene_state(t + h, q, qd, p);
    if ~(residual <= 1e-12 && all(isfinite([q; qd; state.qdd; state.multipliers])))
        error('scene_rk4_step: the step from t = %g s cannot be relied on: choose a shorter one', t);
    end
end

function [q, qd, residual] = project(t, q, qd, p)
    % Projects coordinates onto the constraints, and rates onto their tangent space.
    for corrections = 0:QRM_MAX_CORRECTIONS
        position = scene_position(t, q, scene_angles(q), p);
        residuals = scene_residuals(position, p);
        residual = max([abs(residuals); 0]);
        if any(isnan(residuals))
            residual = NaN;
        end
        if corrections == QRM_MAX_CORRECTIONS || residual <= QRM_RESIDUAL_ROUNDING
            break
        end
        change = correction(t, q, position, residuals, p);
        if max(abs(change)) <= QRM_CORRECTION_ROUNDING
            break
        end
        q = q + change;
    end
    if ~isempty(residuals)
        qd = qd + correction(t, q, position, scene_velocity_residual(position, qd, p), p);
    end
end

function change = correction(t, q, position, residuals, p)
    % The smallest change in the mass metric that takes residuals back.
    if scene_growth_factor(position, p) <= QRM_MAX_GROWTH
        change = scene_correction(position, residuals, p);
    else
        [others, jacobian] = scene_loop_constraints(t, q, p);
        m = numel(residuals);
        mass_matrix = scene_mass_matrix(q, p);
        solution = pinv([mass_matrix, jacobian.'; jacobian, zeros(m)]) * [zeros(numel(q), 1); -residuals];
        change = solution(1:numel(q));
    end
end
