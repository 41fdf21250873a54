function state = scene_state(t, q, qd, p)
    %SCENE_STATE The state at time `t` with these coordinates and rates, which fulfil the constraints.
    %
    %   `state` has the fields q, qd, qdd and multipliers. `p` holds the parameters: see scene_parameters.
    if ~isequal(size(q), [COORDINATES, 1]) || ~isequal(size(qd), [COORDINATES, 1])
        error('scene_state: coordinates and rates must be columns of COORDINATES numbers');
    end
    angles = scene_angles(q);
    position = scene_position(t, q, angles, p);
    if scene_growth_factor(position, p) <= QRM_MAX_GROWTH
        [qdd, multipliers] = scene_accelerations(position, t, q, qd, angles, p);
    else
        % Where a coordinate cannot follow the others, the equations of motion are solved as a whole.
        [mass_matrix, forces, jacobian, bias] = scene_dynamics(t, q, qd, p);
        m = numel(bias);
        solution = pinv([mass_matrix, jacobian.'; jacobian, zeros(m)]) * [forces; -bias];
        qdd = solution(1:end-m);
        multipliers = solution(end-m+1:end);
    end
    state = struct('q', q, 'qd', qd, 'qdd', qdd, 'multipliers', multipliers);
end
