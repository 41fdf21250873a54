function [state, residual] = scene_rk4_step(t, h, from, p)
    %SCENE_RK4_STEP One step of length `h` from time `t`.
    %
    %   The classical Runge-Kutta formula of order 4, then the projection of coordinates and rates onto the constraints in
    %   the mass metric. Accelerations and multipliers of the state are those of its own position.
    %
    %   `from` is a state with the fields q, qd, qdd and multipliers: see scene_initial_state. `residual` is the
    %   largest residual of a constraint at the end. `p` holds the parameters: see scene_parameters.
    [v2, a2] = stage(t, h / 2, from, from.qd, from.qdd, p);
    [v3, a3] = stage(t, h / 2, from, v2, a2, p);
    [v4, a4] = stage(t, h, from, v3, a3, p);
    q = from.q + h / 6 * (from.qd + 2 * (v2 + v3) + v4);
    qd = from.qd + h / 6 * (from.qdd + 2 * (a2 + a3) + a4);
    for corrections = 0:4
        angles = scene_angles(q);
        position = scene_position(t + h, q, angles, p);
        residuals = scene_residuals(position, p);
        if corrections == 4 || all(abs(residuals) <= 4e-16)
            break
        end
        correction = scene_correction(position, residuals, p);
        if all(abs(correction) <= 1e-15)
            break
        end
        q = q + correction;
    end
    residual = max([abs(residuals); 0]);
    if ~isempty(residuals)
        qd = qd + scene_correction(position, scene_velocity_residual(position, qd, p), p);
    end
    [qdd, multipliers] = scene_accelerations(position, t + h, q, qd, angles, p);
    if ~(residual <= 1e-12 && scene_growth_factor(position, p) <= 1e3 && all(isfinite([qdd; multipliers])))
        error('scene_rk4_step: the step from t = %g s cannot be relied on: choose a shorter one', t);
    end
    state = struct('q', q, 'qd', qd, 'qdd', qdd, 'multipliers', multipliers);
end

function [qd, qdd] = stage(t, part, from, v, a, p)
    % Rates and accelerations `part` of the step away from its beginning, along `v` and `a`.
    q = from.q + part * v;
    qd = from.qd + part * a;
    angles = scene_angles(q);
    position = scene_position(t + part, q, angles, p);
    qdd = scene_accelerations(position, t + part, q, qd, angles, p);
end
